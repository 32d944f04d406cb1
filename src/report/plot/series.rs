//! The content of a plot, before any drawing: panels, series, points and axis ranges.

use crate::bench::{Results, Row};
use crate::report::answer::pareto::{SMALLEST_ERROR, pareto_front, says_nothing, scenes};
use crate::report::format::{Specs, one_line};
use crate::report::plot::axes::Axes;

/// About the resolution of a device timestamp: a time of zero nanoseconds is drawn here.
const SMALLEST_MILLISECONDS: f64 = 1e-6;

/// One measured row.
pub(in crate::report) struct Point {
    /// Time, clamped to the axis.
    pub(in crate::report) milliseconds: f64,
    /// 5th and 95th percentile of the time, if known.
    pub(in crate::report) spread_milliseconds: Option<(f64, f64)>,
    /// Mean absolute error, clamped to the panel's floor.
    pub(in crate::report) error: f64,
    /// Number of nodes; empty for a technique without nodes.
    pub(in crate::report) label: String,
    /// Whether no point is both faster and closer to the truth.
    pub(in crate::report) on_front: bool,
}

/// Points drawn in one color and joined by a line.
pub(in crate::report) struct Series {
    /// `avsm two-pass linear`.
    pub(in crate::report) name: String,
    /// Sorted by number of nodes, if it is a number.
    pub(in crate::report) points: Vec<Point>,
}

/// The lowest possible error of a curve with a given number of nodes.
pub(in crate::report) struct Limit {
    /// Mean absolute error.
    pub(in crate::report) error: f64,
    /// `8 nodes`.
    pub(in crate::report) label: String,
}

/// One scene.
pub(in crate::report) struct Panel {
    /// The scene's name.
    pub(in crate::report) scene: String,
    /// In the order in which they were first measured.
    pub(in crate::report) series: Vec<Series>,
    /// Sorted by error.
    pub(in crate::report) limits: Vec<Limit>,
    /// Error at which a line represents all errors too small for the logarithmic axis, if there are any.
    pub(in crate::report) floor: Option<f64>,
    /// Range of the axis, with a margin at both ends.
    pub(in crate::report) milliseconds: (f64, f64),
    /// Range of the axis, with a margin at both ends.
    pub(in crate::report) error: (f64, f64),
}

/// Returns one panel for each scene that has a row with a time and an error.
pub(in crate::report) fn panels(results: &Results, axes: &Axes) -> Vec<Panel> {
    let specs = Specs::of(&results.rows);
    scenes(results).into_iter().filter_map(|scene| panel(results, axes, scene, &specs)).collect()
}

fn panel(results: &Results, axes: &Axes, scene: &str, specs: &Specs) -> Option<Panel> {
    let rows: Vec<(&Row, (f64, f64))> =
        results.rows.iter().filter(|row| row.scene == scene).filter_map(|row| Some((row, axes.point(row)?))).collect();
    let measured: Vec<(f64, f64)> = rows.iter().map(|&(_, point)| point).collect();
    if says_nothing(&measured) {
        return None;
    }
    let front = pareto_front(&measured);

    let smallest_shown = measured.iter().map(|&(_, error)| error).filter(|&e| e >= SMALLEST_ERROR).reduce(f64::min);
    let floor = measured.iter().any(|&(_, error)| error < SMALLEST_ERROR).then(|| match smallest_shown {
        // A whole power of ten, at least a factor of two below all errors that are not clamped.
        Some(smallest) => 10f64.powf((smallest / 2.0).log10().floor()).max(SMALLEST_ERROR / 10.0),
        None => SMALLEST_ERROR,
    });

    let mut series: Vec<Series> = Vec::new();
    for (place, &(row, (milliseconds, error))) in rows.iter().enumerate() {
        let point = Point {
            milliseconds: milliseconds.max(SMALLEST_MILLISECONDS),
            spread_milliseconds: (axes.spread_milliseconds)(row),
            error: floor.map_or(error, |floor| error.max(floor)),
            label: row.variant.get("nodes").map(|nodes| one_line(nodes)).unwrap_or_default(),
            on_front: front.contains(&place),
        };
        let name = series_name(row, specs);
        match series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => series.push(Series { name, points: vec![point] }),
        }
    }
    for series in &mut series {
        // The sort is stable: points whose label is not a number keep their order, after the numbers.
        series.points.sort_by_key(|point| point.label.parse::<u64>().unwrap_or(u64::MAX));
    }

    let limits = limits(&rows, axes);
    let points = || series.iter().flat_map(|series| &series.points);
    let times = points().map(|point| point.milliseconds);
    let errors = points().map(|point| point.error).chain(limits.iter().map(|limit| limit.error));
    Some(Panel {
        scene: one_line(scene),
        milliseconds: range_with_air(times)?,
        error: range_with_air(errors)?,
        series,
        limits,
        floor,
    })
}

/// Names a series: technique, path, curve and all other keys that differ between rows, except the nodes, which label the points.
fn series_name(row: &Row, specs: &Specs) -> String {
    let mut words = vec![row.technique.clone(), row.path.clone()];
    words.extend(row.variant.get("curve").cloned());
    let others = specs.differing(row).filter(|(key, _)| !["nodes", "curve"].contains(key));
    words.extend(others.map(|(key, value)| format!("{key}={value}")));
    one_line(&words.join(" "))
}

/// Returns the limits to plot: one for each number of nodes on whose limit all rows agree. A sweep over sizes has several limits per
/// number, which would clutter the plot.
fn limits(rows: &[(&Row, (f64, f64))], axes: &Axes) -> Vec<Limit> {
    let mut limits: Vec<Limit> = Vec::new();
    let mut disputed = Vec::new();
    for (row, _) in rows {
        let (Some(error), Some(nodes)) = ((axes.limit)(row), row.variant.get("nodes")) else { continue };
        if !error.is_finite() || error < SMALLEST_ERROR {
            continue;
        }
        let label = one_line(&format!("{nodes} nodes"));
        match limits.iter().find(|limit| limit.label == label) {
            Some(known) if (known.error / error - 1.0).abs() > 0.01 => disputed.push(label),
            Some(_) => {}
            None => limits.push(Limit { error, label }),
        }
    }
    limits.retain(|limit| !disputed.contains(&limit.label));
    limits.sort_by(|a, b| b.error.total_cmp(&a.error));
    limits
}

/// Returns the range of an axis: at least a factor of four, with a twelfth of the values' extent free at both ends.
pub(in crate::report) fn range_with_air(values: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let low = values.clone().reduce(f64::min)?.log10();
    let high = values.reduce(f64::max)?.log10();
    let air = ((high - low) / 12.0).max(0.08);
    let missing = (4f64.log10() - (high - low + 2.0 * air)).max(0.0) / 2.0;
    Some((10f64.powf(low - air - missing), 10f64.powf(high + air + missing)))
}

/// Returns the axis lines, and whether each has a label: at 1, 2 and 5 on a short axis, at powers of ten on a long one.
pub(in crate::report) fn ticks((low, high): (f64, f64)) -> Vec<(f64, bool)> {
    let decades = (high / low).log10();
    let labelled: &[i32] = match decades {
        d if d < 1.2 => &[1, 2, 3, 5, 7],
        d if d < 2.4 => &[1, 2, 5],
        _ => &[1],
    };
    let mut ticks = Vec::new();
    for exponent in low.log10().floor() as i32..=high.log10().floor() as i32 {
        for digit in 1..=9 {
            // Parsed rather than computed, so that 0.3 is 0.3 and not 0.30000000000000004.
            let value: f64 = format!("{digit}e{exponent}").parse().unwrap_or(f64::NAN);
            if value >= low && value <= high {
                ticks.push((value, labelled.contains(&digit)));
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_two_decades_and_of_many() {
        let labelled = |range| -> Vec<f64> {
            ticks(range).into_iter().filter(|&(_, labelled)| labelled).map(|(value, _)| value).collect()
        };
        assert_eq!(labelled((0.3, 25.0)), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(labelled((2e-4, 2.0)), [1e-3, 1e-2, 1e-1, 1.0]);
        assert_eq!(labelled((0.9, 3.6)), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn one_value_gets_a_range_around_it() {
        let (low, high) = range_with_air([2.0].into_iter()).expect("there is a value");
        assert!((high / low - 4.0).abs() < 1e-9 && (low * high - 4.0).abs() < 1e-9, "{low} {high}");
        assert!(range_with_air(std::iter::empty()).is_none());
    }
}
