//! The Pareto front: the points that no other point beats in both time and error.

use crate::bench::Results;
use crate::report::plot::axes::Axes;

/// Smaller errors are rounding of 32-bit visibility and not worth a decade of the axis.
pub(in crate::report) const SMALLEST_ERROR: f64 = 1e-7;

/// Whether the points offer no choice: no error is above zero, or several rows all have the same error.
pub(in crate::report) fn says_nothing(points: &[(f64, f64)]) -> bool {
    let same = points.len() > 1 && points.iter().all(|point| point.1 == points[0].1);
    same || points.iter().all(|point| point.1 < SMALLEST_ERROR)
}

/// Returns the indices of the points that no other point beats, sorted by the first coordinate. A point beats another if it is no larger in
/// either coordinate and smaller in at least one. Equal points all stay; points with a NaN coordinate never make the front.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| !points[i].0.is_nan() && !points[i].1.is_nan()).collect();
    // The index breaks ties, so that equal points keep the caller's order.
    order.sort_unstable_by(|&a, &b| {
        points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)).then(a.cmp(&b))
    });
    let mut front: Vec<usize> = Vec::new();
    for index in order {
        // Points come sorted by the first coordinate, so only the last point on the front can be at least as good in the second.
        let stays = front.last().is_none_or(|&last| points[index].1 < points[last].1 || points[index] == points[last]);
        if stays {
            front.push(index);
        }
    }
    front
}

/// Returns the indices into `results.rows` of the rows on their scene's front, in measured order.
pub(in crate::report) fn rows_on_front(results: &Results, axes: &Axes) -> Vec<usize> {
    let mut on_front = Vec::new();
    for scene in scenes(results) {
        let (rows, points): (Vec<_>, Vec<_>) = results
            .rows
            .iter()
            .enumerate()
            .filter(|(_, row)| row.scene == scene)
            .filter_map(|(index, row)| Some((index, axes.point(row)?)))
            .unzip();
        if says_nothing(&points) {
            continue;
        }
        on_front.extend(pareto_front(&points).into_iter().map(|place| rows[place]));
    }
    on_front.sort_unstable();
    on_front
}

/// Returns the scenes in the order in which they were first measured.
pub(in crate::report) fn scenes(results: &Results) -> Vec<&str> {
    let mut scenes: Vec<&str> = Vec::new();
    for row in &results.rows {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    scenes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the front by definition: compares every pair of points.
    fn by_definition(points: &[(f64, f64)]) -> Vec<usize> {
        let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
        (0..points.len()).filter(|&i| !points.iter().any(|&other| beats(other, points[i]))).collect()
    }

    #[test]
    fn known_front() {
        // (3, 3) is beaten by (2, 2); (2, 5) by both (1, 5) and (2, 2); (5, 1) by (4, 1).
        let points = [(3.0, 3.0), (1.0, 5.0), (2.0, 2.0), (2.0, 5.0), (4.0, 1.0), (5.0, 1.0)];
        assert_eq!(pareto_front(&points), [1, 2, 4]);
    }

    #[test]
    fn ties_and_not_a_number() {
        assert_eq!(pareto_front(&[]), [] as [usize; 0]);
        assert_eq!(pareto_front(&[(1.0, 1.0), (1.0, 1.0)]), [0, 1]);
        assert_eq!(pareto_front(&[(f64::NAN, 0.0), (1.0, 0.0), (0.0, f64::NAN)]), [1]);
    }

    #[test]
    fn agrees_with_the_definition_on_a_grid_of_small_sets() {
        // Takes every seventh of the sets of five points with coordinates in {0, 1, 2}. As 7 and 9 have no common factor, each point still
        // takes every value.
        for code in (0..9u32.pow(5)).step_by(7) {
            let points: Vec<(f64, f64)> = (0..5)
                .map(|place| {
                    let cell = code / 9u32.pow(place) % 9;
                    (f64::from(cell / 3), f64::from(cell % 3))
                })
                .collect();
            let mut front = pareto_front(&points);
            front.sort_unstable();
            assert_eq!(front, by_definition(&points), "{points:?}");
        }
    }
}
