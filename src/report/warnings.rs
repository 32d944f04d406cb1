//! Notes that a reader needs besides the figures.

use crate::bench::{PartError, PointError, Results, Row, Stability, StageRates, Status, spearman};
use crate::report::format::grouped;

/// Smallest number of rows per scene for which comparing the orders of two figures means anything.
const ENOUGH_ROWS: usize = 5;

/// Returns reasons not to trust a row: unsteady times, and wrong points that the technique's resolution does not excuse.
pub(super) fn warnings(row: &Row) -> Vec<String> {
    not_steady(row).into_iter().chain(PLACES.iter().filter_map(|place| wrong(row, place))).collect()
}

/// Returns one line per kind of [`warnings`], however many rows have it: for a single row its name and warning, for several their number
/// and the worst.
pub(super) fn notes(rows: &[Row], name: impl Fn(&Row) -> String) -> Vec<String> {
    let steady = note_of_times(rows, &name);
    steady.into_iter().chain(PLACES.iter().filter_map(|place| note_of_points(rows, place, &name))).collect()
}

fn note_of_times(rows: &[Row], name: &dyn Fn(&Row) -> String) -> Option<String> {
    let found: Vec<(&Row, Stability)> = rows.iter().filter_map(|row| Some((row, unsteady(row)?))).collect();
    if let [(row, _)] = found[..] {
        return Some(format!("{}: {}", name(row), not_steady(row)?));
    }
    let all: Vec<Stability> = found.iter().map(|(_, steadiness)| *steadiness).collect();
    let again = all.iter().filter(|steadiness| steadiness.measured_again).count();
    let again = (again > 0).then(|| format!("the steadier of two ({again})"));
    let reasons: Vec<_> = Stability::warnings_of(&all).into_iter().chain(again).collect();
    let (some, all) = (found.len(), rows.len());
    (some > 0).then(|| format!("{some} of {all} rows were not steady: {}", reasons.join(", ")))
}

fn note_of_points(rows: &[Row], place: &Place, name: &dyn Fn(&Row) -> String) -> Option<String> {
    let found: Vec<(&Row, PartError)> = rows.iter().filter_map(|row| Some((row, beyond(row, place)?))).collect();
    let (worst, points) = found.iter().max_by_key(|(_, points)| points.leaks + points.false_shadows)?;
    if found.len() == 1 {
        return Some(format!("{}: {}", name(worst), wrong(worst, place)?));
    }
    let (some, all, counts, name) = (found.len(), rows.len(), counts(points), name(worst));
    Some(format!("{some} of {all} rows are wrong {}, beyond their own resolution: at most {counts}, {name}", place.0))
}

/// Where a technique is queried, and how to find a row's errors there.
type Place = (&'static str, fn(&Row) -> Option<PointError>);

const PLACES: [Place; 2] =
    [("in space", |row| row.error.as_ref()?.space), ("on surfaces", |row| row.error.as_ref()?.surface)];

fn unsteady(row: &Row) -> Option<Stability> {
    row.steadiness.filter(|steadiness| !steadiness.warnings().is_empty())
}

fn not_steady(row: &Row) -> Option<String> {
    let steadiness = unsteady(row)?;
    let again = if steadiness.measured_again { ", the steadier of two" } else { "" };
    Some(format!("not steady: {}{again}", steadiness.warnings().join(", ")))
}

/// Returns the errors at points that the technique resolves, if any is wrong.
fn beyond(row: &Row, (_, points): &Place) -> Option<PartError> {
    points(row)?.beyond().filter(|points| points.leaks + points.false_shadows > 0)
}

fn wrong(row: &Row, place: &Place) -> Option<String> {
    Some(format!("{}, beyond its own resolution: {}", place.0, counts(&beyond(row, place)?)))
}

fn counts(points: &PartError) -> String {
    format!("{} leaks, {} false shadows", grouped(points.leaks), grouped(points.false_shadows))
}

/// Symbol printed after the times of a row whose times are not comparable.
pub(super) const MARK: &str = "†";

/// Returns `17 rows are marked …` with the reason, as one sentence without a full stop; `None` if no row is marked. Pass `stages` to
/// include the device's rates if the text nearby does not.
pub(super) fn marked(rows: &[Row], stages: Option<StageRates>) -> Option<String> {
    let count = rows.iter().filter(|row| !row.marks.is_empty()).count();
    let (rows, their) = match count {
        0 => return None,
        1 => ("1 row is".to_owned(), "its"),
        count => (format!("{} rows are", grouped(count as u64)), "their"),
    };
    let device = stages.map(|stages| format!(", and {}", stages.sentence())).unwrap_or_default();
    Some(format!(
        "{rows} marked {MARK}: more than a quarter of {their} time is raster work{device}; {their} times decide no answer"
    ))
}

/// Returns Spearman's rank correlation of seen error and FLIP, which models the eye, for each scene: whether both order its rows alike.
/// `None` if too few rows have both.
pub(super) fn agreement(results: &Results) -> Option<String> {
    let both = |row: &Row| {
        let error = row.error.as_ref().filter(|_| row.status == Status::Ok)?;
        Some((error.seen?.mean, error.image?.flip_mean))
    };
    let of_scene = |scene: &&str| {
        let pairs: Vec<_> = results.rows.iter().filter(|row| row.scene == *scene).filter_map(both).collect();
        let rank = spearman(&pairs).filter(|_| pairs.len() >= ENOUGH_ROWS)?;
        Some(format!("{scene} {rank:.2} ({} rows)", pairs.len()))
    };
    let scenes: Vec<_> = crate::report::answer::pareto::scenes(results).iter().filter_map(of_scene).collect();
    (!scenes.is_empty()).then(|| format!("rank correlation (Spearman) of seen error and FLIP: {}", scenes.join(", ")))
}
