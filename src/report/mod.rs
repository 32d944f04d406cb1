//! [`Results`](crate::bench::Results) as tables, plots and pages for people, and as files.
//!
//! | what | output |
//! |---|---|
//! | [`Store::write`] | `results.json` and `results.csv`, after every row, atomically |
//! | [`table`](fn@table) | the terminal |
//! | [`passes`](fn@passes) | the terminal, on request |
//! | [`counts`](fn@counts), [`casters`](fn@casters), [`footprints`](fn@footprints) | the terminal, on request |
//! | [`recommend`](fn@recommend) | the terminal: which technique to use for a scene |
//! | [`changes_table`], [`changes_json`] | the terminal, if there is a baseline |
//! | [`junit`], [`bencher`] | files for CI, on request |
//! | [`plots`](fn@plots) | an SVG for each pair of time and error, such as `time-vs-error.svg`; `footprints.svg` on request |
//! | [`page`](fn@page) | `report.html`: the above, the pictures and the definitions in one self-contained file |
//! | [`write_whole`], [`write_png`] | any other file, written atomically |
//! | [`stress_table`], [`stress_csv`], [`stress_page`] | results of `gobo stress`: the terminal, `stress.csv`, `stress.html` |
//! | [`devices_page`], [`devices_markdown`], [`devices_csv`] | `devices.html`, `.md` and `.csv` of `gobo report`: devices side by side |
//! | [`submission_table`] | the terminal, for `gobo submit`: Markdown |
//! | [`soak_page`] | `soak.html` of `gobo stress --soak` |
//!
//! [`pareto_front`] finds the rows that no other row beats in both time and error. `columns.rs` alone lists the columns that the table and
//! the page share, and `axes.rs` the axes of plots. The same results give the same bytes.

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
