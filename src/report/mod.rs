//! [`Results`](crate::bench::Results) as tables, plots and pages for people, and as files.
//!
//! | what | where it goes |
//! |---|---|
//! | [`Store::write`] | `results.json` and `results.csv`, after every row, atomically |
//! | [`table`](fn@table) | the terminal |
//! | [`passes`](fn@passes) | the terminal, where it is asked for |
//! | [`counts`](fn@counts), [`casters`](fn@casters), [`footprints`](fn@footprints) | the terminal, where they are asked for |
//! | [`recommend`](fn@recommend) | the terminal: which technique for a scene |
//! | [`changes_table`], [`changes_json`] | the terminal, where there is a baseline |
//! | [`junit`], [`bencher`] | files for CI, where they are asked for |
//! | [`plots`](fn@plots) | `time-vs-error.svg`, `frame-vs-error.svg`, and `footprints.svg` where they are asked for |
//! | [`page`](fn@page) | `report.html`: the above, the pictures and the definitions in one file without network |
//! | [`write_whole`], [`write_png`] | any other file, as whole |
//! | [`stress_table`], [`stress_csv`], [`stress_page`] | the same of `gobo stress`: the terminal, `stress.csv`, `stress.html` |
//! | [`devices_page`], [`devices_markdown`], [`devices_csv`] | `devices.html`, `.md`, `.csv`, of `gobo report`: devices side by side |
//! | [`submission_table`] | the terminal, of `gobo submit`: Markdown |
//! | [`soak_page`] | `soak.html`, of `gobo stress --soak` |
//!
//! [`pareto_front`] says which rows no other row beats in both time and error. The columns that the table and the page
//! share are listed once, in `columns.rs`, and the axes of plots in `axes.rs`. Same results, same bytes out.

mod answer;
mod file;
mod page;
mod plot;
mod table;

mod devices;
mod format;
mod warnings;

pub use answer::pareto::pareto_front;
pub use answer::recommend::{Limits, Recommendation, answers, recommend};
pub use answer::screening::{best_and_extremes, is_far, is_hopeless, to_be_sized};
pub use devices::{devices_answer, devices_csv, devices_json, devices_markdown, devices_page};
pub use file::atomic_write::{remove_unfinished, write_png, write_whole};
pub use file::store::Store;
pub use file::trace::trace;
pub(crate) use format::one_line;
pub use page::page;
pub use page::soak::soak_page;
pub use page::stress::{stress_csv, stress_device, stress_page, stress_table};
pub use plot::curve::curve;
pub use plot::panels::{Panel, Paper, captioned, panels, with_scale};
pub use plot::plots;
pub use plot::steps::{StepRange, step_color};
pub use table::casters::casters;
pub use table::counts::counts;
pub use table::footprints::footprints;
pub use table::passes::passes;
pub use table::regression::{Fails, bencher, changes_json, changes_table, junit};
pub use table::submission::submission_table;
pub use table::table;
