//! The progress of a comparison: a bar on a terminal, a line per row elsewhere.

use crate::Result;
use crate::bench::{Observer, Results, Row, Status};
use crate::cli::complain;
use crate::technique::Spec;
use indicatif::{ProgressBar, ProgressStyle};
use std::cell::{Cell, RefCell};
use std::io::IsTerminal;
use std::time::Instant;

/// Progress over a number of rows.
pub struct Progress {
    bar: ProgressBar,
    /// Whether a line per row is printed, as for a log.
    lines: bool,
    rows: usize,
    done: Cell<usize>,
    start: Instant,
    /// The scene whose rows are being measured.
    scene: RefCell<String>,
}

impl Progress {
    /// Shows the progress of `rows` rows.
    pub fn new(rows: usize) -> Self {
        let bar = ProgressBar::new(rows as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed}, {eta} left: {wide_msg}") {
            bar.set_style(style);
        }
        let (lines, start) = (!std::io::stderr().is_terminal(), Instant::now());
        Self { bar, lines, rows, done: Cell::new(0), start, scene: RefCell::default() }
    }

    /// Shows that the measurement of a row begins.
    pub fn begins(&self, scene: &str, spec: &Spec) {
        self.bar.set_message(format!("{scene}: {}", spec.short()));
        self.bar.tick();
        // A scene's truth is computed before its first row ends, which may take long.
        if self.lines && self.scene.replace(scene.to_owned()) != scene {
            complain(format!("[{}/{}] {scene}: begins with {}", self.done.get(), self.rows, spec.short()));
        }
    }

    /// Shows that the measurement of a row has ended.
    pub fn ends(&self, row: &Row, spec: &Spec) {
        self.bar.inc(1);
        self.done.set(self.done.get() + 1);
        if self.lines {
            let took_s = self.start.elapsed().as_secs_f64();
            complain(line([self.done.get(), self.rows], took_s, row, spec));
        }
    }

    /// Removes the bar, after the last row.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// An observer for a run that writes nothing before it ends.
impl Observer for Progress {
    fn row_begins(&mut self, scene: &str, spec: &Spec) {
        self.begins(scene, spec);
    }

    fn row_ends(&mut self, row: &Row, spec: &Spec, _: &Results) -> Result<()> {
        self.ends(row, spec);
        Ok(())
    }
}

/// Returns the log line after `done` of `rows` rows, with an estimate of the time left.
fn line([done, rows]: [usize; 2], took_s: f64, row: &Row, spec: &Spec) -> String {
    let left_s = took_s / done as f64 * (rows - done) as f64;
    let left = if done < rows { format!(", {left_s:.0} s left") } else { String::new() };
    format!("[{done}/{rows}] {took_s:.1} s{left} {}: {} {}", row.scene, spec.short(), outcome(row))
}

/// Returns a row's main figures in a few words.
fn outcome(row: &Row) -> String {
    if row.status != Status::Ok {
        return row.reason.lines().next().unwrap_or_default().to_owned();
    }
    let mut words = vec![row.path.clone()];
    words.extend(row.build_ns.map(|build| format!("build {:.3} ms", build.median / 1e6)));
    let seen = row.error.as_ref().and_then(|error| error.seen);
    words.extend(seen.map(|seen| format!("seen error {:.3e}", seen.mean)));
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{RowError, SeenError};
    use crate::shading::parse;

    #[test]
    fn a_line_is_short_and_says_what_is_left() {
        let spec = parse("avsm:size=8").expect("valid").remove(0);
        let row = Row { scene: "town".into(), technique: "avsm".into(), path: "binned".into(), ..Row::default() };
        assert_eq!(line([2, 8], 3.0, &row, &spec), "[2/8] 3.0 s, 9 s left town: avsm:size=8 binned");
        assert_eq!(line([8, 8], 12.0, &row, &spec), "[8/8] 12.0 s town: avsm:size=8 binned");
        let seen = Some(SeenError { mean: 0.25, ..SeenError::default() });
        let error = Some(RowError { seen, map: None, space: None, surface: None, casters: None, image: None });
        assert!(line([8, 8], 12.0, &Row { error, ..row }, &spec).ends_with("binned, seen error 2.500e-1"));
    }
}
