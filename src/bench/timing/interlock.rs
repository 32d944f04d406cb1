//! The gain of fragment shader interlock on each device, compared with the other paths that build the same
//! representation.

use crate::bench::results::cross_device::ratio;
use crate::bench::{Comparison, Line, Row, Status, Verdict};

/// The path with interlock, and the paths without it: two passes, rasterization order, bins.
pub const PATHS: [&str; 4] = ["interlock", "two-pass", "raster-order", "binned"];

/// One scene and spec on one device, built by every path.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// Index of the column.
    pub column: usize,
    /// Indices of the lines, in the order of [`PATHS`].
    pub lines: [Option<usize>; PATHS.len()],
}

impl Comparison {
    /// Returns every scene and spec for which two columns have a row with path=interlock, built or refused; if there is
    /// none, one column is enough. Scenes and specs are in the order of the lines, and each has an entry per column
    /// that has rows for at least two paths.
    pub fn built(&self) -> Vec<Vec<Built>> {
        let path = |line: &Line| self.any(line).variant.get("path").map_or("", String::as_str);
        let is_other = |a: &Line, b: &Line| {
            let key = |line: &Line| {
                let row = self.any(line);
                let mut variant = row.variant.clone();
                variant.remove("path");
                (row.scene.clone(), row.technique.clone(), variant)
            };
            key(a) != key(b)
        };
        let interlock = || self.lines.iter().filter(|line| path(line) == PATHS[0]);
        let columns = |line: &Line| line.rows.iter().flatten().count();
        let least = if interlock().any(|line| columns(line) > 1) { 2 } else { 1 };
        let all = interlock().filter(|line| columns(line) >= least).map(|first| {
            let of = |name: &str| self.lines.iter().position(|line| path(line) == name && !is_other(first, line));
            let lines = PATHS.map(of);
            let on = |column: usize| Built {
                column,
                lines: lines.map(|line| line.filter(|&line| self.row(&self.lines[line], column).is_some())),
            };
            (0..self.columns.len()).map(on).filter(|built| built.lines.iter().flatten().count() > 1).collect::<Vec<_>>()
        });
        all.filter(|built| !built.is_empty()).collect()
    }

    /// Returns the row of a path.
    pub fn built_row(&self, built: &Built, path: usize) -> Option<&Row> {
        self.row(&self.lines[built.lines[path]?], built.column)
    }

    /// Returns a path's build time as a multiple of interlock's.
    pub fn over_interlock(&self, built: &Built, path: usize) -> Option<(f64, Verdict)> {
        let rows = [self.built_row(built, path)?, self.built_row(built, 0)?];
        (rows.iter().all(|row| row.status == Status::Ok && row.marks.is_empty()))
            .then(|| ratio(rows, |row| row.build_ns))
            .flatten()
    }
}
