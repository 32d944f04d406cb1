//! Decides which row of a scene is *best*: the single function behind all recommendations.

use crate::bench::{Row, Status, compute_ns};
use crate::report::format::one_line;

/// A quarter of a step of an 8-bit display; smaller errors are not worth more time.
pub(in crate::report) const CLOSE_ENOUGH: f64 = 1e-3;

/// A picture is wrong if its FLIP exceeds `WRONG` times the least FLIP of all rows that cost at most `AS_DEAR` times as much.
const WRONG: f64 = 1.5;
const AS_DEAR: f64 = 1.25;

/// Smallest share of a picture's time that counts as different from zero, however steady its samples are.
const RESOLVED: f64 = 0.005;

/// A kind of error by which rows are compared.
#[derive(Clone, Copy)]
pub(in crate::report) struct Measure {
    /// Name in a sentence.
    pub(in crate::report) name: &'static str,
    pub(in crate::report) of: fn(&Row) -> Option<f64>,
    /// Time that the error is weighed against.
    pub(in crate::report) time: Time,
}

/// A kind of time by which rows are compared, in nanoseconds.
#[derive(Clone, Copy)]
pub(in crate::report) struct Time {
    /// Words after a number of milliseconds.
    pub(in crate::report) unit: &'static str,
    /// Name in a sentence.
    pub(in crate::report) name: &'static str,
    pub(in crate::report) of: fn(&Row) -> Option<f64>,
}

/// Time that is compared if times are marked: a build and look-ups in compute shaders, which run on all processors.
pub(in crate::report) const COMPUTE: Time =
    Time { unit: "ms for a build and 10⁶ look-ups", name: "time of build and look-ups", of: compute_ns };
const COST: Time = Time { unit: "ms added to a frame", name: "cost", of: |row| row.cost_ns };
/// Time that is compared in older files, which lack the unshadowed picture.
const FRAME: Time = Time { unit: "ms per frame", name: "frame time", of: |row| row.frame_ns };
/// Time that is compared if the device has no timestamps.
const HOST: Time =
    Time { unit: "ms per build by the host's clock", name: "build time", of: |row| Some(row.host_ns?.median) };

/// Kinds of errors, by precedence.
const ERRORS: [Measure; 5] = [
    Measure { name: "seen error", of: |row| Some(row.error.as_ref()?.seen?.mean), time: COST },
    FLIP,
    Measure { name: "surface error", of: |row| Some(row.error.as_ref()?.surface?.mean_abs), time: COST },
    Measure { name: "error in space", of: |row| Some(row.error.as_ref()?.space?.mean_abs), time: COST },
    Measure { name: "map error", of: |row| Some(row.error.as_ref()?.map?.mean_abs), time: COST },
];
pub(in crate::report) const FLIP: Measure =
    Measure { name: "FLIP", of: |row| Some(row.error.as_ref()?.image?.flip_mean), time: COST };

/// Selected rows of a scene, by their index in the results.
pub(in crate::report) struct Answer {
    /// Row with the smallest product of time and error: a row that costs twice as much needs half the error. `None` if times decide
    /// nothing.
    pub(in crate::report) best: Option<usize>,
    /// Rows whose product cannot be told apart from that of `best`: the bands of their times overlap.
    pub(in crate::report) equal: Vec<usize>,
    /// `None` if times decide nothing.
    pub(in crate::report) fastest: Option<usize>,
    pub(in crate::report) closest: usize,
    pub(in crate::report) smallest: Option<usize>,
    /// Number of candidates with a marked time, and number of all candidates.
    pub(in crate::report) marked: [usize; 2],
    /// Measured rows without the deciding kind of error, since their technique paints the picture itself.
    pub(in crate::report) left_out: Vec<usize>,
    /// Measured rows with the deciding error but without the time: on a lopsided device, rows whose builds draw.
    pub(in crate::report) untimed: Vec<usize>,
}

/// Returns the kind of error that decides: the first that any measured row has. Older files have no seen error; FLIP decides there if
/// pictures were made. The time is the cost, or else the frame time. If most times are marked, it is the time of a build and a million
/// look-ups.
pub(in crate::report) fn measure(rows: &[(usize, &Row)]) -> Measure {
    measure_by(rows, COST)
}

/// Same as [`measure`], but weighs errors against the host's build time if no row has a frame time.
pub(in crate::report) fn measure_of_any(rows: &[(usize, &Row)]) -> Measure {
    let has_frames = rows.iter().any(|(_, row)| row.status == Status::Ok && row.frame_ns.or(row.cost_ns).is_some());
    measure_by(rows, if has_frames { COST } else { HOST })
}

fn measure_by(rows: &[(usize, &Row)], time: Time) -> Measure {
    let shadowed = || rows.iter().filter(|(_, row)| row.status == Status::Ok && row.technique != "none");
    let has_cost = shadowed().any(|(_, row)| row.cost_ns.is_some());
    let (marked, all) = (shadowed().filter(|(_, row)| !row.marks.is_empty()).count(), shadowed().count());
    let is_compute = 2 * marked > all && shadowed().any(|(_, row)| compute_ns(row).is_some());
    let time = match () {
        () if is_compute => COMPUTE,
        () if time.name == COST.name && !has_cost => FRAME,
        () => time,
    };
    let found = ERRORS.into_iter().find(|measure| shadowed().any(|(_, row)| (measure.of)(row).is_some()));
    Measure { time, ..found.unwrap_or(ERRORS[0]) }
}

/// Returns the milliseconds and the error of a row that was measured and has both.
pub(in crate::report) fn point(row: &Row, measure: &Measure) -> Option<(f64, f64)> {
    let point = ((measure.time.of)(row)? / 1e6, (measure.of)(row)?);
    (row.status == Status::Ok && point.0.is_finite() && point.1.is_finite()).then_some(point)
}

/// Returns the error of the picture without shadows, of the kind that decides: from the rows of `none`, and from what each row recorded
/// about the unshadowed picture. Infinite if neither is known.
pub(in crate::report) fn dark(rows: &[(usize, &Row)], measure: &Measure) -> f64 {
    let is_bare = |(_, row): &&(usize, &Row)| row.technique == "none" && row.status == Status::Ok;
    let of_rows = rows.iter().filter(is_bare).filter_map(|(_, row)| (measure.of)(row));
    let beside = rows.iter().filter_map(|(_, row)| match measure.name {
        "seen error" => row.unshadowed?.seen,
        "FLIP" => row.unshadowed?.flip_mean,
        _ => None,
    });
    of_rows.chain(beside).fold(f64::INFINITY, f64::min)
}

/// Whether a row casts shadows and is closer to the truth than the picture without shadows, by the deciding error and, if measured, by
/// FLIP.
pub(in crate::report) fn is_closer(row: &Row, rows: &[(usize, &Row)], measure: &Measure) -> bool {
    let by_flip = || (FLIP.of)(row).is_none_or(|flip| flip < dark(rows, &FLIP));
    row.technique != "none" && (measure.of)(row).is_some_and(|error| error < dark(rows, measure)) && by_flip()
}

/// Returns the smallest resolvable difference in a row's time, in nanoseconds: the noise of the unshadowed picture.
pub(in crate::report) fn resolved_ns(row: &Row) -> f64 {
    let draw = row.unshadowed.and_then(|bare| bare.draw_ns);
    draw.map_or(0.0, |draw| (0.5 * (draw.p95 - draw.p05)).max(RESOLVED * draw.median))
}

/// Returns a row's cost, but at least the smallest resolvable difference.
pub(in crate::report) fn resolved_cost_ns(row: &Row) -> Option<f64> {
    Some(row.cost_ns?.max(resolved_ns(row)))
}

/// Returns the smallest resolvable difference in the times of these rows, in milliseconds.
pub(in crate::report) fn floor_ms(rows: &[(usize, &Row)], measure: &Measure) -> f64 {
    /// Floor for times that are not differences of two times.
    const LEAST: f64 = 1e-6;
    let is_cost = measure.time.name == COST.name;
    rows.iter().filter(|_| is_cost).map(|(_, row)| resolved_ns(row) / 1e6).fold(LEAST, f64::max)
}

/// A row that may be recommended.
struct Candidate {
    index: usize,
    /// In milliseconds, at least the floor.
    time: f64,
    band: [f64; 2],
    error: f64,
    flip: Option<f64>,
    bytes: Option<u64>,
    is_marked: bool,
}

impl Candidate {
    /// Returns the product that the best row minimizes: time times error.
    fn product(&self, time: f64) -> f64 {
        time * self.error.max(CLOSE_ENOUGH)
    }
}

/// Selects the best row and the extremes. Returns `None` if no row has both a time and an error. The technique `none` is no candidate;
/// neither is a row that is no closer to the truth than `none`, by the deciding error or by FLIP. The best row's picture is not wrong
/// ([`WRONG`]).
pub(in crate::report) fn answer(rows: &[(usize, &Row)], measure: &Measure) -> Option<Answer> {
    let is_compute = measure.time.name == COMPUTE.name;
    let floor = floor_ms(rows, measure);
    let of_row = |&(index, row): &(usize, &Row)| {
        let (ms, error) = point(row, measure)?;
        let band = row.cost_band_ns.filter(|_| measure.time.name == COST.name).map(|band| band.map(|ns| ns / 1e6));
        let candidate = Candidate {
            index,
            time: ms.max(floor),
            band: band.unwrap_or([ms; 2]).map(|end| end.max(floor)),
            error,
            flip: (FLIP.of)(row),
            bytes: row.bytes_resident,
            is_marked: !row.marks.is_empty() && !is_compute,
        };
        is_closer(row, rows, measure).then_some(candidate)
    };
    let all: Vec<Candidate> = rows.iter().filter_map(of_row).collect();
    let is_right = |own: &&Candidate| {
        let as_dear = all.iter().filter(|other| other.time <= AS_DEAR * own.time).filter_map(|other| other.flip);
        let least = as_dear.fold(f64::INFINITY, f64::min);
        own.flip.is_none_or(|flip| flip <= WRONG * least)
    };
    let marked = all.iter().filter(|candidate| candidate.is_marked).count();
    // If most times are marked, the few unmarked rows would be compared with none of the usual techniques.
    let unmarked: Vec<&Candidate> =
        if 2 * marked > all.len() { Vec::new() } else { all.iter().filter(|c| !c.is_marked).collect() };
    let timed: Vec<&Candidate> = unmarked.iter().copied().filter(is_right).collect();
    let least = |of: &[&Candidate], key: &dyn Fn(&Candidate) -> [f64; 2]| {
        let smaller = |a: &&&Candidate, b: &&&Candidate| {
            let (a, b) = (key(a), key(b));
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
        };
        of.iter().min_by(smaller).map(|candidate| candidate.index)
    };
    let best = least(&timed, &|c| [c.product(c.time), c.error]);
    let its = timed.iter().find(|candidate| Some(candidate.index) == best);
    let is_equal = |other: &&&Candidate| {
        its.is_some_and(|best| {
            let [own, other_ends] = [best, **other].map(|c| c.band.map(|end| c.product(end)));
            other.index != best.index && other_ends[0] <= own[1] && own[0] <= other_ends[1]
        })
    };
    let paints = |(_, row): &&(usize, &Row)| {
        row.status == Status::Ok && row.technique != "none" && (measure.of)(row).is_none() && (FLIP.of)(row).is_some()
    };
    let is_untimed = |(_, row): &&(usize, &Row)| {
        row.status == Status::Ok && is_closer(row, rows, measure) && (measure.time.of)(row).is_none()
    };
    Some(Answer {
        best,
        equal: timed.iter().filter(is_equal).map(|candidate| candidate.index).collect(),
        fastest: least(&unmarked, &|c| [c.time, c.error]),
        closest: least(&all.iter().collect::<Vec<_>>(), &|c| [c.error, c.time])?,
        smallest: all.iter().filter_map(|c| Some((c.bytes?, c.index))).min().map(|(_, index)| index),
        marked: [marked, all.len()],
        left_out: rows.iter().filter(paints).map(|(index, _)| *index).collect(),
        untimed: rows.iter().filter(is_untimed).map(|(index, _)| *index).collect(),
    })
}

/// Explains why no row is chosen by its time.
pub(in crate::report) fn why_untimed(answer: &Answer, rows: &[(usize, &Row)]) -> String {
    let [marked, all] = answer.marked;
    let closest = rows.iter().find(|(index, _)| *index == answer.closest);
    let why = closest.and_then(|(_, row)| row.marks.first()).map(|mark| format!(" ({mark})")).unwrap_or_default();
    one_line(&format!("the times of {marked} of {all} rows decide nothing here{why}"))
}

#[cfg(test)]
pub(in crate::report) mod tests {
    use super::*;
    use crate::bench::{ImageError, RowError, SeenError, Timing, Unshadowed};

    /// Builds a row with a cost in milliseconds and a seen error.
    pub(in crate::report) fn row(technique: &str, ms: f64, error: f64) -> Row {
        let seen = Some(SeenError { mean: error, ..SeenError::default() });
        let error = Some(RowError { seen, map: None, space: None, surface: None, casters: None, image: None });
        Row { technique: technique.into(), cost_ns: Some(ms * 1e6), error, ..Row::default() }
    }

    fn with_flip(mut row: Row, flip_mean: f64) -> Row {
        let image = ImageError { rmse: 0.0, flip_mean, bounce_rmse: None, bounce_noise: None };
        row.error.as_mut().expect("an error").image = Some(image);
        row
    }

    fn of(rows: &[Row]) -> Option<Answer> {
        let rows: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
        answer(&rows, &measure(&rows))
    }

    /// A row with a wrong picture must not be the best, however good its product. It is wrong only in comparison with pictures of about the
    /// same cost.
    #[test]
    fn what_the_picture_shows_to_be_wrong_is_not_named() {
        let best = |flips: [f64; 3]| {
            let rows = [row("none", 0.0, 0.5), row("flat", 1.0, 0.01), row("deep", 1.2, 0.02), row("exact", 1.3, 0.03)];
            let flips = std::iter::once(0.2).chain(flips);
            of(&rows.into_iter().zip(flips).map(|(row, flip)| with_flip(row, flip)).collect::<Vec<_>>())
        };
        let named = |flips: [f64; 3]| best(flips).expect("measured").best;
        assert_eq!(named([0.010, 0.010, 0.001]), Some(1));
        assert_eq!(named([0.016, 0.010, 0.007]), Some(2));
        // The third row costs within a quarter more than the second, but not than the first.
        assert_eq!(named([0.016, 0.010, 0.006]), Some(3));
        // By FLIP no row is closer than no shadow.
        assert!(best([0.2, 0.3, 0.4]).is_none());
    }

    /// Marked times must decide nothing: the best and the quickest row come from the other rows, and do not exist if most rows are marked.
    #[test]
    fn marked_times_decide_nothing() {
        let marked = |row: Row| Row { marks: vec!["81 % raster work".into()], ..row };
        let rows = [row("none", 0.0, 0.5), marked(row("a", 1.0, 0.01)), row("b", 2.0, 0.02), row("c", 3.0, 0.03)];
        let found = of(&rows).expect("measured");
        assert_eq!((found.best, found.fastest, found.closest, found.marked), (Some(2), Some(2), 1, [1, 3]));
        let rows =
            [row("none", 0.0, 0.5), marked(row("a", 1.0, 0.01)), marked(row("b", 2.0, 0.02)), row("c", 3.0, 0.03)];
        let found = of(&rows).expect("measured");
        assert_eq!((found.best, found.fastest, found.closest), (None, None, 1));
        let numbered: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
        assert_eq!(why_untimed(&found, &numbered), "the times of 2 of 3 rows decide nothing here (81 % raster work)");
    }

    /// If most times are marked, the time of a build and a million look-ups must decide instead.
    #[test]
    fn what_compute_takes_stands_for_marked_times() {
        let timed = |row: Row, build: f64, look_up: f64| Row {
            marks: vec!["81 % raster work".into()],
            build_ns: Timing::of(&[1e6 * build]),
            lookup_ns_per_million: Timing::of(&[1e6 * look_up]),
            ..row
        };
        let rows = [row("none", 0.0, 0.5), timed(row("a", 1.0, 0.02), 2.0, 3.0), timed(row("b", 9.0, 0.03), 1.0, 1.0)];
        let numbered: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
        assert_eq!(measure(&numbered).time.name, COMPUTE.name);
        let found = of(&rows).expect("measured");
        assert_eq!((found.best, found.fastest, found.closest), (Some(2), Some(2), 1));
    }

    /// Costs below the noise of the unshadowed picture must be raised to that noise, and rows whose product bands overlap must count as
    /// equal.
    #[test]
    fn noise_is_no_difference() {
        let draw = Timing { median: 50e6, p05: 49e6, p95: 51e6, samples: 30 };
        let row = |technique: &str, ms: f64, off: f64, error: f64| Row {
            unshadowed: Some(Unshadowed { draw_ns: Some(draw), seen: Some(0.5), flip_mean: None }),
            cost_band_ns: Some([ms - off, ms + off].map(|ms| 1e6 * ms)),
            ..row(technique, ms, error)
        };
        // The first cost is below the noise of 1 ms and is raised to it, so the error of 0.01 at 1.5 ms beats it.
        let rows =
            [row("a", -3.0, 0.5, 0.02), row("b", 1.5, 0.1, 0.01), row("c", 3.2, 0.4, 0.005), row("d", 9.0, 0.1, 0.004)];
        let found = of(&rows).expect("measured");
        assert_eq!((found.best, found.equal, found.fastest), (Some(1), vec![2], Some(0)));
        // Without a row of `none`, the unshadowed error comes from the rows themselves.
        assert!(of(&[row("a", 1.0, 0.1, 0.5)]).is_none());
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
        assert_eq!((measure.name, measure.time.name), ("seen error", "cost"));
        assert_eq!((answer.best, answer.fastest, answer.closest, answer.smallest), (Some(4), Some(3), 5, None));
    }

    #[test]
    fn nothing_measured_is_no_answer() {
        let rows = [row("none", 1.0, 0.3), Row::default()];
        let rows: Vec<(usize, &Row)> = rows.iter().enumerate().collect();
        assert!(answer(&rows, &measure(&rows)).is_none());
    }
}
