//! Screening after a first look at the rows: which may be recommended, and which are beaten by far.

use crate::bench::Row;
use crate::report::answer::recommend::Limits;
use crate::report::answer::selection::{
    Answer, CLOSE_ENOUGH, FLIP, Measure, answer, dark, floor_ms, measure_of_any, point,
};

/// Returns the indices of up to four rows: the one with the smallest product of time and error, the quickest, the one with the least error,
/// and the one with the fewest bytes. Empty if nothing was measured.
pub fn best_and_extremes(rows: &[Row], limits: &Limits) -> Vec<usize> {
    found(rows, limits).map_or_else(Vec::new, |(found, _)| {
        [found.best, found.fastest, Some(found.closest), found.smallest].into_iter().flatten().collect()
    })
}

/// Returns the rows of [`best_and_extremes`] to measure in other sizes too: the best, the quickest, and the one with the least error unless
/// that error is small enough already. The row with the fewest bytes is left out, since nobody wants the fewest bytes regardless of size.
pub fn to_be_sized(rows: &[Row], limits: &Limits) -> Vec<usize> {
    let Some((found, measure)) = found(rows, limits) else { return Vec::new() };
    let is_exact = point(&rows[found.closest], &measure).is_some_and(|(_, error)| error <= CLOSE_ENOUGH);
    let mut all: Vec<usize> = found.best.into_iter().chain(found.fastest).collect();
    all.extend((!is_exact).then_some(found.closest));
    all.sort_unstable();
    all.dedup();
    all
}

fn found(rows: &[Row], limits: &Limits) -> Option<(Answer, Measure)> {
    let rows: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
    let measure = limits.measure(&rows);
    Some((answer(&rows, &measure)?, measure))
}

/// Factors by which times and errors are compared in a first look. Ratios up to `ALIKE` count as equal. A time counts as longer at a ratio
/// of `SLOWER` or more, an error as larger at `FARTHER` or more. `FARTHER` is larger, although errors at few points are steadier than times
/// of few frames: an error looks larger only if it is half as large again, while a row that takes a quarter longer is not worth its time.
const ALIKE: f64 = 1.05;
const SLOWER: f64 = 1.25;
const FARTHER: f64 = 1.5;

/// Whether a row has failed, or another row beats it by far. The other row does so if it is no worse in time and error, better by far in
/// one of them, and no larger in any figure that has a limit. Errors below `CLOSE_ENOUGH`, or below the error limit if that is smaller,
/// count as equal to it. A row that lacks a limited figure beats no other. The technique `none` is the baseline and never hopeless.
pub fn is_hopeless(row: &Row, rows: &[Row], limits: &Limits) -> bool {
    let measure = measure_of_any(&rows.iter().enumerate().collect::<Vec<_>>());
    if row.technique == "none" {
        return false;
    }
    let worth = |error: f64| error.max(limits.error.map_or(CLOSE_ENOUGH, |asked| asked.min(CLOSE_ENOUGH)));
    let floor = floor_ms(&rows.iter().enumerate().collect::<Vec<_>>(), &measure);
    let timed = |row: &Row| point(row, &measure).map(|(time, error)| (time.max(floor), worth(error)));
    let Some((time, error)) = timed(row) else { return true };
    let no_more = |limited: bool, a: Option<f64>, b: Option<f64>| !limited || a.zip(b).is_some_and(|(a, b)| a <= b);
    let bytes = |row: &Row| row.bytes_resident.map(|bytes| bytes as f64);
    rows.iter().filter(|other| other.technique != "none").any(|other| {
        let Some((t, e)) = timed(other) else { return false };
        let no_worse = t < ALIKE * time && e < ALIKE * error;
        no_worse
            && (SLOWER * t < time || FARTHER * e < error)
            && no_more(limits.ms.is_some(), Some(t), Some(time))
            && no_more(limits.error.is_some(), Some(e), Some(error))
            && no_more(limits.flip.is_some(), (FLIP.of)(other), (FLIP.of)(row))
            && no_more(limits.bytes.is_some(), bytes(other), bytes(row))
    })
}

/// Factors beyond which a technique's first row rules out its other specs: `WORSE` applies to the best row's product of time and error and
/// to the closest row's error, `LATER` to the quickest row's time. On the rows measured so far, this never dropped a spec that was best,
/// quickest or closest (docs/reference/recommend.md).
const WORSE: f64 = 3.0;
const LATER: f64 = 1.5;

/// Whether a row is so far from the best, the quickest and the closest row that no other spec of its technique can be one of them. As in a
/// recommendation, a row that is no closer than `none` counts as none of the three. The technique `none` and rows that were not measured
/// are never far.
pub fn is_far(row: &Row, rows: &[Row]) -> bool {
    let measure = measure_of_any(&rows.iter().enumerate().collect::<Vec<_>>());
    let numbered: Vec<_> = rows.iter().enumerate().collect();
    let (dark, floor) = (dark(&numbered, &measure), floor_ms(&numbered, &measure));
    let shadowed = rows.iter().filter(|row| row.technique != "none").filter_map(|row| point(row, &measure));
    let worth = |(time, error): (f64, f64)| (time.max(floor), error.max(CLOSE_ENOUGH));
    let Some((time, error)) = point(row, &measure).map(worth).filter(|_| row.technique != "none") else { return false };
    let others: Vec<(f64, f64)> = shadowed.filter(|point| point.1 < dark).map(worth).collect();
    let beaten = |by: &dyn Fn((f64, f64)) -> bool| others.iter().any(|other| by(*other));
    beaten(&|(t, e)| WORSE * t * e < time * error)
        && beaten(&|(t, _)| LATER * t < time)
        && beaten(&|(_, e)| WORSE * e < error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{ImageError, RowError, SeenError, Status};
    use crate::report::answer::selection::tests::row;

    #[test]
    fn what_is_beaten_by_far_is_hopeless() {
        let of = |technique: &str, ms: f64, error: f64, bytes: u64| {
            let seen = Some(SeenError { mean: error, ..SeenError::default() });
            let error = Some(RowError { seen, map: None, space: None, surface: None, casters: None, image: None });
            let cost_ns = Some(ms * 1e6);
            Row { technique: technique.into(), cost_ns, error, bytes_resident: Some(bytes), ..Row::default() }
        };
        let failed = Row { status: Status::Failed, ..of("avsm", 1.0, 0.0, 1) };
        let rows = [
            of("none", 1.0, 0.9, 0),
            of("psm", 2.0, 0.1, 10),
            // Equally close: slower by exactly a quarter, then by more; then slower by more, but closer.
            of("avsm", 2.5, 0.1, 10),
            of("avsm", 2.6, 0.1, 10),
            of("avsm", 2.6, 0.095, 10),
            // The first is as quick as the rows above, with more than one and a half times their error; the second is slightly quicker.
            of("avsm", 1.95, 0.16, 10),
            of("avsm", 1.9, 0.16, 10),
            // Needs fewer bytes.
            of("avsm", 2.6, 0.1, 9),
            failed,
            // Errors too small to be worth any time.
            of("avsm", 3.0, 0.0005, 10),
            of("avsm", 4.0, 0.0001, 10),
        ];
        let hopeless = |limits: Limits| {
            let hopeless = |place: &usize| is_hopeless(&rows[*place], &rows, &limits);
            (0..rows.len()).filter(hopeless).collect::<Vec<usize>>()
        };
        let none = Limits::default();
        assert_eq!(hopeless(none), [3, 5, 7, 8, 10]);
        assert_eq!(hopeless(Limits { bytes: Some(9), ..Limits::default() }), [3, 5, 8, 10]);
        assert_eq!(hopeless(Limits { ms: Some(1.95), ..Limits::default() }), [3, 7, 8, 10]);
        assert_eq!(hopeless(Limits { error: Some(1e-4), ..Limits::default() }), [3, 5, 7, 8]);
        assert_eq!(best_and_extremes(&rows, &none), [9, 6, 10, 7]);
        // The closest row is close enough. Among the first eight rows, whose errors are larger, the closest is not.
        assert_eq!(to_be_sized(&rows, &none), [6, 9]);
        assert_eq!(
            (best_and_extremes(&rows[..8], &none), to_be_sized(&rows[..8], &none)),
            (vec![1, 6, 4, 7], vec![1, 4, 6])
        );
    }

    /// Only a row beyond all three thresholds is far; neither `none` nor a row that was not measured is.
    #[test]
    fn what_is_far_in_each_is_far() {
        let rows = [
            row("none", 0.1, 0.5),
            row("psm", 1.0, 0.01),
            // Exact, but an error below 0.001 is not worth more time.
            row("grid-query", 20.0, 0.0),
            row("moments", 1.6, 0.02),
            // As far in the product, but nearly as quick as the quickest.
            row("beer-shadow-map", 1.4, 0.03),
            // As far in the product, but with an error not much above the closest row's.
            row("uncompressed", 30.0, 0.002),
            // Not far in the product.
            row("avsm", 2.9, 0.01),
            Row { status: Status::Failed, ..row("ism", 9.0, 0.9) },
            // Quick, but no closer than no shadow: it makes no other row far by time.
            row("translucency-map", 0.2, 0.5),
        ];
        let far: Vec<&str> = rows.iter().filter(|row| is_far(row, &rows)).map(|row| row.technique.as_str()).collect();
        assert_eq!(far, ["moments"]);
    }

    /// If FLIP has a limit and a row has no picture, errors at points alone must not drop the row. If it has one, a row with a better FLIP
    /// must stay.
    #[test]
    fn a_limit_of_flip_drops_nothing_by_points_alone() {
        let of = |ms: f64, mean: f64, flip: Option<f64>| {
            let seen = Some(SeenError { mean, ..SeenError::default() });
            let image =
                flip.map(|flip_mean| ImageError { flip_mean, rmse: 0.0, bounce_rmse: None, bounce_noise: None });
            let error = Some(RowError { seen, map: None, space: None, surface: None, casters: None, image });
            Row { technique: "avsm".into(), cost_ns: Some(ms * 1e6), error, ..Row::default() }
        };
        let flip = Limits { flip: Some(0.05), ..Limits::default() };
        for (flips, hopeless) in [
            ([None; 3], [false; 3]),
            ([Some(0.03), None, Some(0.03)], [false, false, true]),
            // The second row meets the limit, and the third is better in no figure.
            ([Some(0.06), Some(0.004), Some(0.06)], [false, false, true]),
        ] {
            let rows = [of(1.0, 0.01, flips[0]), of(2.0, 0.1, flips[1]), of(3.0, 0.1, flips[2])];
            assert_eq!(rows.each_ref().map(|row| is_hopeless(row, &rows, &flip)), hopeless, "{flips:?}");
            assert_eq!(rows.each_ref().map(|row| is_hopeless(row, &rows, &Limits::default())), [false, true, true]);
        }
        // By FLIP the second row is the best, so it is among the rows to measure in other sizes.
        let rows = [of(1.0, 0.01, Some(0.06)), of(2.0, 0.1, Some(0.004))];
        assert_eq!((best_and_extremes(&rows, &flip)[0], best_and_extremes(&rows, &Limits::default())[0]), (1, 0));
        assert!(to_be_sized(&rows, &flip).contains(&1));
    }
}
