//! The axes of each plot.

use crate::bench::{Row, Status};
use crate::report::answer::selection::{resolved_cost_ns, resolved_ns};

/// A time and an error of a row.
pub(in crate::report) struct Axes {
    /// Name of the SVG in the output folder.
    pub(in crate::report) file: &'static str,
    /// Title above the plot.
    pub(in crate::report) title: &'static str,
    /// Description for readers who cannot see the plot.
    pub(in crate::report) aria_label: &'static str,
    /// Both axes, as words in a sentence.
    pub(in crate::report) names: &'static str,
    /// Title of the time axis, below a panel, with its unit.
    pub(in crate::report) time_title: &'static str,
    /// Title of the error axis, on the left of a panel.
    pub(in crate::report) error_title: &'static str,
    milliseconds: fn(&Row) -> Option<f64>,
    /// 5th and 95th percentile, if known.
    pub(in crate::report) spread_milliseconds: fn(&Row) -> Option<(f64, f64)>,
    error: fn(&Row) -> Option<f64>,
    /// Lowest possible error of a curve with the row's number of nodes.
    pub(in crate::report) limit: fn(&Row) -> Option<f64>,
}

/// A build may be short because look-ups do the work; only the frame time includes both.
pub(in crate::report) const AXES: [Axes; 4] = [
    Axes {
        file: "cost-vs-seen.svg",
        title: "What shadows cost against seen error",
        aria_label: "What shadows add to a frame against seen error, one panel per scene",
        names: "cost and seen error",
        time_title: "what shadows add to a frame, ms (bars from p05 to p95)",
        error_title: "seen error: the share of the picture's light that is wrong",
        milliseconds: |row| Some(resolved_cost_ns(row)? / 1e6),
        spread_milliseconds: |row| Some(row.cost_band_ns?.map(|ns| ns.max(resolved_ns(row)) / 1e6).into()),
        error: |row| Some(row.error.as_ref()?.seen?.mean),
        limit: |_| None,
    },
    Axes {
        file: "time-vs-error.svg",
        title: "Build time against map error",
        aria_label: "Build time against mean absolute error at map points, one panel per scene",
        names: "build time and map error",
        time_title: "build time, ms (median; bars from p05 to p95)",
        error_title: "mean absolute error of visibility (map points)",
        milliseconds: |row| Some(row.build_ns?.median / 1e6),
        spread_milliseconds: |row| row.build_ns.map(|timing| (timing.p05 / 1e6, timing.p95 / 1e6)),
        error: |row| Some(row.error.as_ref()?.map?.mean_abs),
        limit: |row| row.limit_mean_abs,
    },
    Axes {
        file: "frame-vs-error.svg",
        title: "Time of a frame against space error",
        aria_label: "Time of a frame against mean absolute error in space, one panel per scene",
        names: "frame time and space error",
        time_title: "time of a frame, ms (a build, and the picture drawn)",
        error_title: "mean absolute error of visibility (in space)",
        milliseconds: |row| Some(row.frame_ns? / 1e6),
        spread_milliseconds: |_| None,
        error: |row| Some(row.error.as_ref()?.space?.mean_abs),
        limit: |_| None,
    },
    Axes {
        file: "frame-vs-surface.svg",
        title: "Time of a frame against surface error",
        aria_label: "Time of a frame against mean absolute error on surfaces, one panel per scene",
        names: "frame time and surface error",
        time_title: "time of a frame, ms (a build, and the picture drawn)",
        error_title: "mean absolute error of visibility (on surfaces)",
        milliseconds: |row| Some(row.frame_ns? / 1e6),
        spread_milliseconds: |_| None,
        error: |row| Some(row.error.as_ref()?.surface?.mean_abs),
        limit: |_| None,
    },
];

impl Axes {
    /// Returns the milliseconds and the error of a row that was measured and has both as finite numbers.
    pub(in crate::report) fn point(&self, row: &Row) -> Option<(f64, f64)> {
        if row.status != Status::Ok {
            return None;
        }
        let point = ((self.milliseconds)(row)?, (self.error)(row)?);
        (point.0.is_finite() && point.1.is_finite()).then_some(point)
    }
}
