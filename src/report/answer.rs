//! Which row of a scene is *best*.

use crate::measure::{Row, Status};

/// Errors below this are a quarter of a step of an 8-bit display: a smaller error is not worth more time.
pub(super) const CLOSE_ENOUGH: f64 = 1e-3;

/// A kind of error by which rows are compared.
#[derive(Clone, Copy)]
pub(super) struct Measure {
    /// Its name in a sentence.
    pub(super) name: &'static str,
    pub(super) of: fn(&Row) -> Option<f64>,
    /// The time that the error is weighed against.
    pub(super) time: Time,
}

/// A kind of time by which rows are compared, nanoseconds.
#[derive(Clone, Copy)]
pub(super) struct Time {
    /// The words behind a number of milliseconds.
    pub(super) unit: &'static str,
    pub(super) of: fn(&Row) -> Option<f64>,
}

const FRAME: Time = Time { unit: "ms per frame", of: |row| row.frame_ns };
/// The time for rows of a device without timestamps.
const HOST: Time = Time { unit: "ms per build by the host's clock", of: |row| Some(row.host_ns?.median) };

/// Errors over all points of a kind, in the order in which a user looks at them.
const ERRORS: [Measure; 3] = [
    Measure { name: "surface error", of: |row| Some(row.error.as_ref()?.surface?.mean_abs), time: FRAME },
    Measure { name: "error in space", of: |row| Some(row.error.as_ref()?.space?.mean_abs), time: FRAME },
    Measure { name: "map error", of: |row| Some(row.error.as_ref()?.map?.mean_abs), time: FRAME },
];
pub(super) const FLIP: Measure =
    Measure { name: "FLIP", of: |row| Some(row.error.as_ref()?.image?.flip_mean), time: FRAME };

/// Rows of a scene by their index in the results.
pub(super) struct Answer {
    /// The row with the smallest product of frame time and error: a row with twice the time needs half the error.
    pub(super) best: usize,
    pub(super) fastest: usize,
    pub(super) closest: usize,
    pub(super) smallest: Option<usize>,
}

/// The kind of error that most rows have; among equals, the first. FLIP where no row has errors of points.
pub(super) fn measure(rows: &[(usize, &Row)]) -> Measure {
    measure_by(rows, FRAME)
}

/// As [`measure`], but weighed against the host's time of a build where no row has the time of a frame.
pub(super) fn measure_of_any(rows: &[(usize, &Row)]) -> Measure {
    let has_frames = rows.iter().any(|(_, row)| row.status == Status::Ok && row.frame_ns.is_some());
    measure_by(rows, if has_frames { FRAME } else { HOST })
}

fn measure_by(rows: &[(usize, &Row)], time: Time) -> Measure {
    let with_time = |measure: Measure| Measure { time, ..measure };
    let count = |measure: &Measure| rows.iter().filter(|(_, row)| point(row, measure).is_some()).count();
    let errors = ERRORS.map(with_time);
    let most = errors.iter().map(count).max().unwrap_or(0);
    errors.into_iter().find(|measure| most > 0 && count(measure) == most).unwrap_or(with_time(FLIP))
}

/// Milliseconds and the error, of a row that was measured and has both.
pub(super) fn point(row: &Row, measure: &Measure) -> Option<(f64, f64)> {
    let point = ((measure.time.of)(row)? / 1e6, (measure.of)(row)?);
    (row.status == Status::Ok && point.0.is_finite() && point.1.is_finite()).then_some(point)
}

/// The answer to which row is best. None where no row has both a time and an error. The technique `none` cannot be the
/// answer, and neither can a row that is no closer to the truth than `none`.
pub(super) fn answer(rows: &[(usize, &Row)], measure: &Measure) -> Option<Answer> {
    let measured = |&(index, row): &(usize, &Row)| Some((index, row.technique != "none", point(row, measure)?));
    let all: Vec<_> = rows.iter().filter_map(measured).collect();
    let dark = all.iter().filter(|(_, shadows, _)| !shadows).map(|(_, _, point)| point.1).fold(f64::INFINITY, f64::min);
    let points: Vec<(usize, (f64, f64))> =
        all.iter().filter(|(_, shadows, point)| *shadows && point.1 < dark).map(|&(i, _, point)| (i, point)).collect();
    let least = |of: &dyn Fn((f64, f64)) -> (f64, f64)| {
        let key = |point| of(point);
        let smaller = |a: &&(usize, (f64, f64)), b: &&(usize, (f64, f64))| {
            let (a, b) = (key(a.1), key(b.1));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        points.iter().min_by(smaller).map(|&(index, _)| index)
    };
    let bytes = |index: usize| rows.iter().find(|(i, _)| *i == index).and_then(|(_, row)| row.bytes_resident);
    Some(Answer {
        best: least(&|(time, error)| (time * error.max(CLOSE_ENOUGH), error))?,
        fastest: least(&|(time, error)| (time, error))?,
        closest: least(&|(time, error)| (error, time))?,
        smallest: points.iter().filter_map(|&(index, _)| Some((bytes(index)?, index))).min().map(|(_, index)| index),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::measure::{PointError, RowError};

    /// A row of a frame's milliseconds and an error in space.
    pub(in crate::report) fn row(technique: &str, ms: f64, error: f64) -> Row {
        let space = Some(PointError { mean_abs: error, ..PointError::default() });
        let error = Some(RowError { map: None, space, surface: None, casters: None, image: None });
        Row { technique: technique.into(), frame_ns: Some(ms * 1e6), error, ..Row::default() }
    }

    #[test]
    fn what_takes_twice_as_long_has_to_be_twice_as_close() {
        // `none` is the fastest, and `map` is no closer; the list is exact and slow.
        let rows = [
            row("none", 1.0, 0.3),
            row("map", 1.5, 0.3),
            row("a", 4.0, 0.02),
            row("b", 2.0, 0.05),
            row("c", 7.0, 0.01),
            row("list", 9000.0, 0.0),
        ];
        let rows: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
        let measure = measure(&rows);
        let answer = answer(&rows, &measure).expect("measured");
        assert_eq!(measure.name, "error in space");
        assert_eq!((answer.best, answer.fastest, answer.closest, answer.smallest), (4, 3, 5, None));
    }

    #[test]
    fn nothing_measured_is_no_answer() {
        let rows = [row("none", 1.0, 0.3), Row::default()];
        let rows: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
        assert!(answer(&rows, &measure(&rows)).is_none());
    }
}
