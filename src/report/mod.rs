//! [`Results`](crate::measure::Results) as tables, plots and pages for people, and as files.
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

mod atomic_write;
mod axes;
mod casters;
mod colors;
mod columns;
mod counts;
mod curve;
mod devices;
mod footprint_plot;
mod footprints;
mod format;
mod page;
mod panels;
mod pareto;
mod passes;
mod plot;
mod recommend;
mod regression;
mod scatter;
mod screening;
mod selection;
mod series;
mod soak;
mod steps;
mod store;
mod stress;
mod submission;
mod summary;
mod table;
mod trace;
mod warnings;

pub use atomic_write::{remove_unfinished, write_png, write_whole};
pub use casters::casters;
pub use counts::counts;
pub use curve::curve;
pub use devices::{devices_answer, devices_csv, devices_json, devices_markdown, devices_page};
pub use footprints::footprints;
pub(crate) use format::one_line;
pub use page::page;
pub use panels::{Panel, Paper, captioned, panels, with_scale};
pub use pareto::pareto_front;
pub use passes::passes;
pub use plot::plots;
pub use recommend::{Limits, Recommendation, answers, recommend};
pub use regression::{Fails, bencher, changes_json, changes_table, junit};
pub use screening::{best_and_extremes, is_far, is_hopeless, to_be_sized};
pub use soak::soak_page;
pub use steps::{StepRange, step_color};
pub use store::Store;
pub use stress::{stress_csv, stress_device, stress_page, stress_table};
pub use submission::submission_table;
pub use table::table;
pub use trace::trace;
