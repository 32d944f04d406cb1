//! Changes since an earlier comparison, row by row: times with their noise, errors and bytes.

use crate::bench::{Results, Row, Status, Timing};

/// Minimum number of samples needed to estimate a timing's noise.
pub(in crate::bench) const FEWEST_SAMPLES: usize = 5;

/// Factor by which times of unsteady rows may differ although the program is unchanged, because of other processes or a
/// different clock rate.
const UNSTEADY: f64 = 2.0;

/// An error below this is due to rounding of 32-bit visibility.
const ROUNDING: f64 = 1e-7;

/// Relative tolerances for changes: 0.05 is 5 % of the earlier figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Tolerated change of times.
    pub time: f64,
    /// Tolerated change of errors.
    pub error: f64,
}

impl Default for Margins {
    fn default() -> Self {
        Self { time: 0.05, error: 0.01 }
    }
}

/// How a figure has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Changed by less than the margin, or less than the noise.
    Same,
    /// Faster, or closer to the truth.
    Better,
    /// Slower, or farther from the truth.
    Worse,
    /// A time that cannot be distinguished from noise: too few samples, or one of the rows was not steady.
    Unknown,
}

/// One figure of a row, before and now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Its name: `build`, `look-up`, `draw`, `map error`, `space error`, `surface error`, `FLIP`, `resident`.
    pub name: &'static str,
    /// The earlier value: nanoseconds, a mean absolute error, or bytes.
    pub before: f64,
    /// The current value, in the same unit.
    pub now: f64,
    /// How it has changed.
    pub verdict: Verdict,
}

impl Figure {
    /// Returns the relative increase over the earlier value; `None` if the earlier value was 0.
    pub fn share(&self) -> Option<f64> {
        (self.before != 0.0).then(|| self.now / self.before - 1.0)
    }

    /// Whether the figure is a time.
    pub fn is_time(&self) -> bool {
        TIMES.iter().any(|(name, _)| *name == self.name)
    }

    /// Whether the figure is an error.
    pub fn is_error(&self) -> bool {
        ERRORS.iter().any(|(name, _)| *name == self.name)
    }
}

/// A row and its earlier counterpart.
#[derive(Clone, Debug, PartialEq)]
pub enum Change<'a> {
    /// The row exists both before and now.
    Both {
        /// The current row.
        now: &'a Row,
        /// Figures that both rows have.
        figures: Vec<Figure>,
    },
    /// The row was measured before and is refused or failed now, or vice versa.
    Status {
        /// The earlier row.
        before: &'a Row,
        /// The current row.
        now: &'a Row,
    },
    /// The row did not exist before.
    New(&'a Row),
    /// The row no longer exists.
    Gone(&'a Row),
}

impl Change<'_> {
    /// Returns the current row, or the earlier one if the row is gone.
    pub fn row(&self) -> &Row {
        match self {
            Self::Both { now, .. } | Self::Status { now, .. } => now,
            Self::New(row) | Self::Gone(row) => row,
        }
    }

    fn any(&self, of: fn(&Figure) -> bool) -> bool {
        let Self::Both { figures, .. } = self else { return false };
        figures.iter().any(|figure| of(figure) && figure.verdict == Verdict::Worse)
    }

    /// Whether a time has grown beyond margin and noise.
    pub fn is_slower(&self) -> bool {
        self.any(Figure::is_time)
    }

    /// Whether every time can be distinguished from noise, and none has grown.
    pub fn is_no_slower(&self) -> bool {
        let Self::Both { figures, .. } = self else { return false };
        let good = |figure: &Figure| matches!(figure.verdict, Verdict::Same | Verdict::Better);
        figures.iter().filter(|figure| figure.is_time()).all(good)
    }

    /// Whether an error has grown beyond its margin.
    pub fn is_worse(&self) -> bool {
        self.any(Figure::is_error)
    }

    /// Whether the row can no longer be measured.
    pub fn is_lost(&self) -> bool {
        matches!(self, Self::Status { before, .. } if before.status == Status::Ok)
    }
}

/// The name of a figure, and the function that reads it from a row.
pub(in crate::bench) type Named<T> = (&'static str, fn(&Row) -> Option<T>);

const TIMES: [Named<Timing>; 3] =
    [("build", |row| row.build_ns), ("look-up", |row| row.lookup_ns_per_million), ("draw", |row| row.draw_ns)];

pub(in crate::bench) const ERRORS: [Named<f64>; 5] = [
    ("seen error", |row| Some(row.error.as_ref()?.seen?.mean)),
    ("map error", |row| Some(row.error.as_ref()?.map?.mean_abs)),
    ("space error", |row| Some(row.error.as_ref()?.space?.mean_abs)),
    ("surface error", |row| Some(row.error.as_ref()?.surface?.mean_abs)),
    ("FLIP", |row| Some(row.error.as_ref()?.image?.flip_mean)),
];

/// Compares every row of `now` with the same row of `before`, in the order of `now`, followed by the rows that `now`
/// lacks. Two rows are the same if they have the same scene, technique, and values of all keys that both have. Each row
/// of `before` is matched with at most one row of `now`.
pub fn changes<'a>(before: &'a Results, now: &'a Results, margins: Margins) -> Vec<Change<'a>> {
    let mut left: Vec<&Row> = before.rows.iter().collect();
    let mut changes: Vec<Change> = now
        .rows
        .iter()
        .map(|row| {
            let Some(place) = place(left.iter().copied(), row) else { return Change::New(row) };
            change(left.remove(place), row, margins)
        })
        .collect();
    changes.extend(left.into_iter().map(Change::Gone));
    changes
}

/// Compares one row with the first row of `before` that is the same; `None` if there is none.
pub fn change_of<'a>(before: &'a Results, now: &'a Row, margins: Margins) -> Option<Change<'a>> {
    place(before.rows.iter(), now).map(|place| change(&before.rows[place], now, margins))
}

/// Merges several runs of one command into one: the times of two processes differ by more than the samples within one
/// process. The result is the first run, with each time's band extended to enclose the bands of all runs, and with the
/// median of all runs' medians. `None` without a run.
pub fn together(runs: &[Results]) -> Option<Results> {
    let (first, others) = runs.split_first()?;
    let mut all = first.clone();
    for row in &mut all.rows {
        let same: Vec<&Row> = others.iter().filter_map(|run| Some(&run.rows[place(run.rows.iter(), row)?])).collect();
        let with = |of: fn(&Row) -> Option<Timing>, first: Option<Timing>| {
            let timings: Vec<Timing> = first.into_iter().chain(same.iter().filter_map(|row| of(row))).collect();
            let medians = Timing::of(&timings.iter().map(|timing| timing.median).collect::<Vec<_>>())?;
            let p05 = timings.iter().map(|timing| timing.p05).fold(f64::INFINITY, f64::min);
            let p95 = timings.iter().map(|timing| timing.p95).fold(f64::NEG_INFINITY, f64::max);
            let samples = timings.iter().map(|timing| timing.samples).sum();
            Some(Timing { median: medians.median, p05, p95, samples })
        };
        row.build_ns = with(|row| row.build_ns, row.build_ns);
        row.lookup_ns_per_million = with(|row| row.lookup_ns_per_million, row.lookup_ns_per_million);
        row.draw_ns = with(|row| row.draw_ns, row.draw_ns);
    }
    Some(all)
}

/// Returns the index of the row in `before` that is the same as `now`. Among several, it prefers the first that also
/// spells its values the same, otherwise the first of all.
fn place<'a>(before: impl Iterator<Item = &'a Row> + Clone, now: &Row) -> Option<usize> {
    let in_words = |old: &Row| old.variant.iter().all(|(key, value)| now.variant.get(key).is_none_or(|is| is == value));
    let is = |old: &Row| is_same(old, now);
    before.clone().position(|old| is(old) && in_words(old)).or_else(|| before.clone().position(is))
}

pub(in crate::bench) fn is_same(before: &Row, now: &Row) -> bool {
    let agree = |key: &String| now.value(key).is_none_or(|other| before.value(key) == Some(other));
    before.scene == now.scene && before.technique == now.technique && before.variant.keys().all(agree)
}

fn change<'a>(before: &'a Row, now: &'a Row, margins: Margins) -> Change<'a> {
    if before.status != now.status {
        return Change::Status { before, now };
    }
    let steady = [before, now].iter().all(|row| row.steadiness.is_none_or(|s| s.warnings().is_empty()));
    let times = TIMES.iter().filter_map(|(name, of)| {
        let (was, is) = (of(before)?, of(now)?);
        let verdict = time_verdict(was, is, margins.time, steady);
        Some(Figure { name, before: was.median, now: is.median, verdict })
    });
    let errors = ERRORS.iter().filter_map(|(name, of)| {
        let (was, is) = (of(before)?, of(now)?);
        Some(Figure { name, before: was, now: is, verdict: error_verdict(was, is, margins.error) })
    });
    let bytes = before.bytes_resident.zip(now.bytes_resident).map(|(was, is)| {
        // A byte count has no noise, and a larger one is neither slower nor less accurate.
        Figure { name: "resident", before: was as f64, now: is as f64, verdict: Verdict::Same }
    });
    Change::Both { now, figures: times.chain(errors).chain(bytes).collect() }
}

/// Compares two times. They count as the same if their bands, from the 5th to the 95th percentile, overlap. Otherwise
/// the ratio of the medians is compared with the margin.
pub(in crate::bench) fn time_verdict(before: Timing, now: Timing, margin: f64, steady: bool) -> Verdict {
    if before.samples.min(now.samples) < FEWEST_SAMPLES {
        return Verdict::Unknown;
    }
    let more = |a: Timing, b: Timing, factor: f64| a.p05 > b.p95 && a.median > b.median * factor;
    let (factor, unsteady) = (1.0 + margin, UNSTEADY.max(1.0 + margin));
    match [more(now, before, factor), more(before, now, factor)] {
        [false, false] => Verdict::Same,
        [slower, _] if steady || more(now, before, unsteady) || more(before, now, unsteady) => {
            if slower {
                Verdict::Worse
            } else {
                Verdict::Better
            }
        }
        _ => Verdict::Unknown,
    }
}

pub(in crate::bench) fn error_verdict(before: f64, now: f64, margin: f64) -> Verdict {
    if now > before * (1.0 + margin) + ROUNDING {
        Verdict::Worse
    } else if before > now * (1.0 + margin) + ROUNDING {
        Verdict::Better
    } else {
        Verdict::Same
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{PointError, RowError};

    fn timing(median: f64, half: f64) -> Timing {
        Timing { median, p05: median - half, p95: median + half, samples: 30 }
    }

    fn row(key: &str, build: Timing, error: f64) -> Row {
        let space = Some(PointError { mean_abs: error, ..PointError::default() });
        Row {
            scene: "s".into(),
            technique: "avsm".into(),
            variant: [("nodes".to_owned(), key.to_owned())].into(),
            build_ns: Some(build),
            error: Some(RowError { seen: None, map: None, space, surface: None, casters: None, image: None }),
            bytes_resident: Some(8),
            ..Row::default()
        }
    }

    fn results(rows: &[Row]) -> Results {
        Results { rows: rows.to_vec(), ..Results::default() }
    }

    #[test]
    fn a_time_has_changed_where_bands_are_apart_and_medians_beyond_the_margin() {
        let was = timing(100.0, 2.0);
        for (now, verdict) in [
            (timing(100.0, 2.0), Verdict::Same),
            // The bands are apart, but within the margin.
            (timing(104.5, 1.0), Verdict::Same),
            // Beyond the margin, but within the noise.
            (timing(110.0, 9.0), Verdict::Same),
            (timing(110.0, 2.0), Verdict::Worse),
            (timing(90.0, 2.0), Verdict::Better),
            (Timing { samples: 4, ..timing(200.0, 1.0) }, Verdict::Unknown),
        ] {
            assert_eq!(time_verdict(was, now, 0.05, true), verdict, "{now:?}");
        }
    }

    #[test]
    fn an_error_has_changed_beyond_its_margin_and_rounding() {
        for (before, now, verdict) in [
            (0.1, 0.1009, Verdict::Same),
            (0.1, 0.102, Verdict::Worse),
            (0.102, 0.1, Verdict::Better),
            (0.0, 5e-8, Verdict::Same),
            (0.0, 1e-3, Verdict::Worse),
            (1e-3, 0.0, Verdict::Better),
        ] {
            assert_eq!(error_verdict(before, now, 0.01), verdict, "{before} {now}");
        }
    }

    #[test]
    fn rows_are_matched_by_what_both_say() {
        let old = results(&[
            row("4", timing(10.0, 0.1), 0.1),
            row("8", timing(20.0, 0.1), 0.05),
            row("9", timing(1.0, 0.1), 0.0),
        ]);
        // A key that the older program lacked.
        let mut first = row("8", timing(30.0, 0.1), 0.05);
        first.variant.insert("lately".into(), "on".into());
        let mut refused = row("9", timing(1.0, 0.1), 0.0);
        refused.status = Status::Refused;
        let new = results(&[first, row("16", timing(1.0, 0.1), 0.0), refused]);
        let found = changes(&old, &new, Margins::default());
        let nodes: Vec<_> = found.iter().map(|change| change.row().variant["nodes"].as_str()).collect();
        assert_eq!(nodes, ["8", "16", "9", "4"]);
        assert!(found[0].is_slower() && !found[0].is_worse());
        assert!(matches!(found[1], Change::New(_)) && found[2].is_lost() && matches!(found[3], Change::Gone(_)));
        let Change::Both { figures, .. } = &found[0] else { panic!("both") };
        assert_eq!(figures[0].share(), Some(0.5));
        assert_eq!(figures.iter().map(|figure| figure.name).collect::<Vec<_>>(), ["build", "space error", "resident"]);
    }

    /// A row with a default in its older spelling must match a row with the default in its current spelling. In a sweep
    /// over both spellings, each row must match the row with its own spelling.
    #[test]
    fn a_default_is_known_by_its_old_word() {
        let row = |storage: &str, detail: &str, error: f64| {
            let mut row = row("8", timing(10.0, 0.1), error);
            row.technique = "avsm".into();
            row.variant.extend([("storage", storage), ("detail", detail)].map(|(k, v)| (k.to_owned(), v.to_owned())));
            row
        };
        let errors = |old: &[Row], new: &[Row]| {
            let (old, new) = (results(old), results(new));
            let change = |change: &Change| match change {
                Change::Both { figures, .. } => figures.iter().find(|f| f.is_error()).map(|f| f.before),
                _ => None,
            };
            let again = |row| change_of(&old, row, Margins::default()).and_then(|found| change(&found));
            assert!(changes(&old, &new, Margins::default()).iter().map(change).eq(new.rows.iter().map(again)));
            new.rows.iter().map(again).collect::<Vec<_>>()
        };
        let old = [row("full", "even", 0.1), row("packed", "even", 0.2)];
        let new = [row("packed", "even", 0.2), row("auto", "even", 0.1)];
        assert_eq!(errors(&old, &new), [Some(0.2), Some(0.1)]);
        let old = [row("full", "adaptive", 0.1)];
        assert!(matches!(
            changes(&results(&old), &results(&[row("auto", "adaptive", 0.1)]), Margins::default())[0],
            Change::New(_)
        ));
        let both = [row("full", "even", 0.1), row("auto", "even", 0.2)];
        assert_eq!(errors(&both, &[both[1].clone(), both[0].clone()]), [Some(0.2), Some(0.1)]);
    }

    /// A build time of 13 must count as slower than 10, but not as slower than the merged runs of 10, 12.9 and 11,
    /// whose band reaches 12.9.
    #[test]
    fn several_runs_have_one_band() {
        let runs = [10.0, 12.9, 11.0].map(|build| results(&[row("8", timing(build, 0.2), 0.1)]));
        let now = results(&[row("8", timing(13.0, 0.2), 0.1), row("16", timing(1.0, 0.1), 0.1)]);
        let slower = |before: &[Results]| {
            let before = together(before).expect("a run");
            changes(&before, &now, Margins::default())[0].is_slower()
        };
        assert!(slower(&runs[..1]) && slower(&[runs[0].clone(), runs[2].clone()]) && !slower(&runs));
        let all = together(&runs).expect("runs").rows[0].build_ns.expect("timed");
        let each = runs.each_ref().map(|run| run.rows[0].build_ns.expect("timed"));
        assert_eq!((all.median, all.p05, all.p95), (11.0, each[0].p05, each[1].p95));
        assert_eq!(all.samples, each.iter().map(|timing| timing.samples).sum::<usize>());
        assert!(together(&[]).is_none());
    }

    #[test]
    fn what_is_not_steady_has_to_be_far_off() {
        let old = results(&[row("4", timing(10.0, 0.1), 0.1)]);
        for (build, slower) in [(15.0, false), (25.0, true)] {
            let mut now = row("4", timing(build, 0.1), 0.2);
            now.steadiness = Some(crate::bench::Stability { spread: Some(2.0), ..Default::default() });
            let now = results(&[now]);
            let found = changes(&old, &now, Margins::default());
            assert!(found[0].is_slower() == slower && found[0].is_worse(), "{build}");
        }
    }
}
