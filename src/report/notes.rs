//! Notes that a reader needs besides the figures.

use super::wording::grouped;
use crate::measure::{PointError, Results, Row, StageRates, Status, spearman};

/// With fewer rows of a scene, the orders of two figures say nothing.
const ENOUGH_ROWS: usize = 5;

/// Reasons not to trust a row: times that are not steady, and points that are wrong though the technique resolves them.
pub(super) fn warnings(row: &Row) -> Vec<String> {
    let unsteady =
        row.steadiness.map(|s| (s.warnings(), s.measured_again)).filter(|(warnings, _)| !warnings.is_empty());
    let unsteady = unsteady.map(|(warnings, again)| {
        format!("not steady: {}{}", warnings.join(", "), if again { ", the steadier of two" } else { "" })
    });
    let of = |name, points: Option<PointError>| {
        let beyond = points?.beyond().filter(|b| b.leaks + b.false_shadows > 0)?;
        let (leaks, shadows) = (grouped(beyond.leaks), grouped(beyond.false_shadows));
        Some(format!("{name}, beyond its own resolution: {leaks} leaks, {shadows} false shadows"))
    };
    let error = row.error.as_ref();
    let wrong = [("in space", error.and_then(|e| e.space)), ("on surfaces", error.and_then(|e| e.surface))];
    unsteady.into_iter().chain(wrong.into_iter().filter_map(|(name, points)| of(name, points))).collect()
}

/// Behind the times of a row whose times decide nothing.
pub(super) const MARK: &str = "†";

/// `17 rows are marked …`, with the reason, in one sentence without a full stop; none where no row is marked. `stages` is told too where
/// it does not stand nearby.
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

/// Whether seen error puts the rows of each scene in the same order as FLIP, which models the eye: Spearman's rank correlation. None
/// where too few rows have both.
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
    let scenes: Vec<_> = super::pareto::scenes(results).iter().filter_map(of_scene).collect();
    (!scenes.is_empty()).then(|| format!("rank correlation (Spearman) of seen error and FLIP: {}", scenes.join(", ")))
}
