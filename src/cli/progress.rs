//! How far a comparison is: a bar on a terminal, a line a row elsewhere.

use super::complain;
use crate::measure::{Row, Status};
use crate::technique::Spec;
use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;
use std::io::IsTerminal;
use std::time::Instant;

/// Of so many rows.
pub struct Progress {
    bar: ProgressBar,
    /// Rows go to a log.
    lines: bool,
    rows: usize,
    done: Cell<usize>,
    start: Instant,
}

impl Progress {
    /// Begins.
    pub fn new(rows: usize) -> Self {
        let bar = ProgressBar::new(rows as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {wide_msg}") {
            bar.set_style(style);
        }
        Self { bar, lines: !std::io::stderr().is_terminal(), rows, done: Cell::new(0), start: Instant::now() }
    }

    /// A row begins.
    pub fn begins(&self, scene: &str, spec: &Spec) {
        self.bar.set_message(format!("{scene}: {spec}"));
        self.bar.tick();
    }

    /// A row ends.
    pub fn ends(&self, row: &Row) {
        self.bar.inc(1);
        self.done.set(self.done.get() + 1);
        if self.lines {
            complain(format!(
                "[{}/{}] {:.1} s {}: {} {}",
                self.done.get(),
                self.rows,
                self.start.elapsed().as_secs_f64(),
                row.scene,
                row.spec(),
                outcome(row)
            ));
        }
    }

    /// All have ended.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// What is known of a row, in a few words.
fn outcome(row: &Row) -> String {
    if row.status != Status::Ok {
        return row.reason.lines().next().unwrap_or_default().to_owned();
    }
    let mut words = vec![row.path.clone()];
    words.extend(row.build_ns.map(|build| format!("build {:.3} ms", build.median / 1e6)));
    let error = row.error.as_ref().and_then(|error| error.map.or(error.space));
    words.extend(error.map(|error| format!("error {:.3e}", error.mean_abs)));
    words.join(", ")
}
