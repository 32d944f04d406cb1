//! How far a technique keeps its promises in a case: the first value of the case's number at which the answers break a promise.

use super::results::{CaseResult, Figures, Outcome};
use crate::shading::parse;
use crate::technique::Promises;
use serde::{Deserialize, Serialize};

/// Returns the promises of a row's technique; `None` if its spec is not valid.
fn promises(row: &CaseResult) -> Option<Promises> {
    let spec = parse(&row.technique).ok()?.pop()?;
    spec.plan_on(&row.path).map(|plan| plan.promises)
}

/// A promise that was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrokenPromise {
    /// Answers that are infinite or not a number.
    NotFinite,
    /// Answers below 0 or above 1.
    Outside,
    /// Answers that rise with depth along a light ray.
    Rising,
    /// Behind all smoke, transmittance is not the product over all casters.
    Tail,
    /// Answers that depend on the casters' order.
    Order,
    /// The validation layer reported a message.
    Messages,
    /// A call failed, or the process died.
    Failed,
    /// The mean error is above the threshold.
    Error,
    /// Leaks or false shadows outside the boundary.
    Wrong,
    /// Answers change more from frame to frame than the threshold allows.
    Step,
}

impl BrokenPromise {
    /// Whether every technique must keep this promise, however extreme the scene, since no limitation of a method excuses breaking it.
    pub fn is_invariant(self) -> bool {
        !matches!(self, Self::Error | Self::Wrong | Self::Step)
    }

    /// Returns a short text that states the broken promise with its figure.
    fn words(self, figures: &Figures) -> String {
        let most = |figure: Option<f64>| figure.unwrap_or_default();
        match self {
            Self::NotFinite => format!("{} answers not finite", figures.not_finite),
            Self::Outside => format!("{} answers outside [0, 1]", figures.outside),
            Self::Rising => format!("rises by {:.1e}", most(figures.rise)),
            Self::Tail => format!("tail off by {:.1e}", most(figures.tail)),
            Self::Order => format!("order {:.1e}", most(figures.order_spread)),
            Self::Messages => format!("{} validation messages", figures.messages),
            Self::Failed => "failed".into(),
            Self::Error => {
                format!("mean error {:.1e}", most(figures.map.and_then(|m| m.error).map(|e| e.mean_abs)))
            }
            Self::Wrong => format!("{} leaks or false shadows", figures.wrong().unwrap_or(0)),
            Self::Step => format!("step {:.1e}", most(figures.step_rms)),
        }
    }
}

/// Returns all promises that a row breaks.
pub(super) fn broken(row: &CaseResult) -> Vec<BrokenPromise> {
    let figures = match (row.outcome, &row.figures) {
        // A technique that refused or ran out of time has broken no promise.
        (Outcome::Refused | Outcome::NoAnswer, _) => return Vec::new(),
        (Outcome::Failed, _) | (_, None) => return vec![BrokenPromise::Failed],
        (Outcome::Answered, Some(figures)) => figures,
    };
    match promises(row) {
        Some(promises) => broken_of(figures, &promises),
        // A row whose technique is unknown counts as failed, so that nothing goes unchecked.
        None => vec![BrokenPromise::Failed],
    }
}

/// Returns the promises that the figures break, including the invariants that hold for all techniques.
fn broken_of(figures: &Figures, promises: &Promises) -> Vec<BrokenPromise> {
    // NaN counts as above the limit.
    let above =
        |figure: Option<f64>, most: Option<f64>| figure.zip(most).is_some_and(|(f, most)| f.is_nan() || f > most);
    let mean = figures.map.and_then(|map| map.error).map(|error| error.mean_abs);
    [
        (figures.not_finite > 0, BrokenPromise::NotFinite),
        (figures.outside > 0, BrokenPromise::Outside),
        (above(figures.rise, promises.rise), BrokenPromise::Rising),
        (above(figures.tail, promises.tail), BrokenPromise::Tail),
        (above(figures.order_spread, promises.order), BrokenPromise::Order),
        (figures.messages > 0, BrokenPromise::Messages),
        (above(mean, promises.mean), BrokenPromise::Error),
        (figures.wrong().zip(promises.wrong).is_some_and(|(count, most)| count > most), BrokenPromise::Wrong),
        (above(figures.step_rms, promises.step), BrokenPromise::Step),
    ]
    .into_iter()
    .filter_map(|(is_broken, what)| is_broken.then_some(what))
    .collect()
}

/// Returns the invariants ([`BrokenPromise::is_invariant`]) that a row breaks, as texts.
pub(super) fn broken_invariants(row: &CaseResult) -> Vec<String> {
    let figures = row.figures.clone().unwrap_or_default();
    broken(row).into_iter().filter(|broken| broken.is_invariant()).map(|broken| broken.words(&figures)).collect()
}

/// How far a technique holds in a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name of the case, [`super::StressCase::name`].
    pub case: String,
    /// The technique's spec, without defaults.
    pub technique: String,
    /// `holds` if every value holds. `holds up to X` if X holds and a later value breaks. If no value breaks, but one is refused or is not
    /// answered in time, the reason (`refused: …`, `no answer within …`), after `holds up to X` if X holds. `breaks at X` if no value
    /// before X holds.
    pub verdict: String,
    /// The last value that holds before the first that breaks; absent if the first value already breaks or is refused.
    pub holds_up_to: Option<f64>,
    /// The first value at which something breaks.
    pub breaks_at: Option<f64>,
    /// The promises that break at that value.
    pub broken: Vec<BrokenPromise>,
    /// The promises that break, as text with figures, or the reason why there was no answer.
    pub why: String,
    /// Invariants ([`BrokenPromise::is_invariant`]) that break at any value.
    pub invariants: Vec<BrokenPromise>,
    /// Figures at the last value that holds, or at the first value if none holds.
    pub figures: Option<Figures>,
}

impl Verdict {
    /// Returns the verdict on the rows of a technique in a case, in the order of values.
    pub(super) fn of(rows: &[&CaseResult]) -> Option<Self> {
        let first = rows.first()?;
        let found: Vec<_> = rows.iter().map(|row| broken(row)).collect();
        let breaks = found.iter().position(|broken| !broken.is_empty());
        let silent = rows.iter().position(|row| matches!(row.outcome, Outcome::Refused | Outcome::NoAnswer));
        let end = breaks.unwrap_or(rows.len());
        let held = rows[..end].iter().rev().find(|row| row.outcome == Outcome::Answered);
        let verdict = match (held, breaks) {
            (Some(row), None) => match silent {
                Some(at) => {
                    format!("holds up to {}; at {} {}", number(row.value), number(rows[at].value), rows[at].reason)
                }
                None => "holds".into(),
            },
            (Some(row), Some(_)) => format!("holds up to {}", number(row.value)),
            (None, Some(at)) => format!("breaks at {}", number(rows[at].value)),
            (None, None) => silent.map_or_else(String::new, |at| rows[at].reason.clone()),
        };
        let why = breaks.map_or_else(String::new, |at| {
            let words = |broken: &BrokenPromise| match &rows[at].figures {
                Some(figures) => broken.words(figures),
                None => rows[at].reason.clone(),
            };
            found[at].iter().map(words).collect::<Vec<_>>().join(", ")
        });
        let mut invariants: Vec<BrokenPromise> = Vec::new();
        for broken in found.iter().flatten().filter(|broken| broken.is_invariant()) {
            if !invariants.contains(broken) {
                invariants.push(*broken);
            }
        }
        Some(Self {
            case: first.case.clone(),
            technique: first.technique.clone(),
            verdict,
            holds_up_to: held.map(|row| row.value),
            breaks_at: breaks.map(|at| rows[at].value),
            broken: breaks.map(|at| found[at].clone()).unwrap_or_default(),
            why,
            invariants,
            figures: held.or(rows.first()).and_then(|row| row.figures.clone()),
        })
    }
}

/// Formats a number as in the table of cases.
pub(crate) fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if plain { format!("{value}") } else { format!("{value:e}") }
}

/// Returns one verdict per case and technique, in the order of the rows.
pub fn verdicts(rows: &[CaseResult]) -> Vec<Verdict> {
    let mut pairs: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        let pair = (row.case.as_str(), row.technique.as_str());
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    let of = |(case, technique): (&str, &str)| {
        let own: Vec<_> =
            rows.iter().filter(|row| (row.case.as_str(), row.technique.as_str()) == (case, technique)).collect();
        Verdict::of(&own)
    };
    pairs.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::super::results::ErrorSummary;
    use super::*;
    use crate::bench::{PartError, PointError};

    fn row(value: f64, figures: Option<Figures>) -> CaseResult {
        CaseResult {
            case: "case".into(),
            value,
            technique: "avsm:path=two-pass".into(),
            path: "two-pass".into(),
            outcome: Outcome::Answered,
            reason: String::new(),
            figures,
        }
    }

    fn off_by(mean_abs: f64) -> Option<Figures> {
        let error = PointError { mean_abs, ..PointError::default() };
        Some(Figures { map: Some(ErrorSummary { error: Some(error), points: 9 }), ..Figures::default() })
    }

    #[test]
    fn it_holds_up_to_the_last_value_before_the_first_that_breaks() {
        let rows = [row(1.0, off_by(1e-3)), row(10.0, off_by(1e-3)), row(100.0, off_by(0.5)), row(1e6, off_by(0.0))];
        let [verdict] = &verdicts(&rows)[..] else { panic!("one pair") };
        assert_eq!(
            (verdict.verdict.as_str(), verdict.holds_up_to, verdict.breaks_at),
            ("holds up to 10", Some(10.0), Some(100.0))
        );
        assert_eq!((&verdict.broken[..], verdict.why.as_str()), (&[BrokenPromise::Error][..], "mean error 5.0e-1"));
        assert_eq!(verdict.invariants, []);
        assert_eq!(verdicts(&rows[..2])[0].verdict, "holds");
        assert_eq!(verdicts(&rows[2..])[0].verdict, "breaks at 100");
    }

    /// NaN must exceed any threshold, and invariants must be checked at values after the first break too.
    #[test]
    fn what_is_not_a_number_breaks() {
        let spread = |order_spread| Some(Figures { order_spread: Some(order_spread), ..Figures::default() });
        assert_eq!(broken(&row(1.0, spread(0.0))), []);
        assert_eq!(broken(&row(1.0, spread(1e-7))), [BrokenPromise::Order]);
        assert_eq!(broken(&row(1.0, spread(f64::NAN))), [BrokenPromise::Order]);
        let late = Figures { not_finite: 1, ..Figures::default() };
        let rows = [row(1.0, off_by(0.5)), row(2.0, Some(late))];
        assert_eq!(verdicts(&rows)[0].invariants, [BrokenPromise::NotFinite]);
    }

    /// A figure above its promised maximum must break that promise alone, and no figure may break a promise that was not made. Invariants
    /// must hold without any promise.
    #[test]
    fn each_promise_is_held_against_its_figure() {
        let error = PointError {
            points: Some(9),
            mean_abs: 0.3,
            leaks: Some(2),
            false_shadows: Some(1),
            within: Some(PartError { points: 2, leaks: 1, ..PartError::default() }),
            ..PointError::default()
        };
        let asked = ErrorSummary { error: Some(error), points: 9 };
        let figures = Figures {
            map: Some(asked),
            space: Some(asked),
            rise: Some(0.3),
            tail: Some(0.3),
            order_spread: Some(0.3),
            step_rms: Some(0.3),
            ..Figures::default()
        };
        let none = Promises::NONE;
        let of = |most: f64| {
            let (most, wrong) = (Some(most), Some(if most < 0.3 { 1 } else { 2 }));
            [
                (Promises { mean: most, ..none }, BrokenPromise::Error),
                (Promises { tail: most, ..none }, BrokenPromise::Tail),
                (Promises { rise: most, ..none }, BrokenPromise::Rising),
                (Promises { order: most, ..none }, BrokenPromise::Order),
                (Promises { step: most, ..none }, BrokenPromise::Step),
                (Promises { wrong, ..none }, BrokenPromise::Wrong),
            ]
        };
        for (promises, what) in of(0.29) {
            assert_eq!(broken_of(&figures, &promises), [what]);
        }
        assert!(of(0.31).iter().all(|(promises, _)| broken_of(&figures, promises).is_empty()));
        assert_eq!(broken_of(&figures, &none), []);
        let no_number = Figures { not_finite: 1, outside: 1, messages: 1, ..Figures::default() };
        assert_eq!(
            broken_of(&no_number, &none),
            [BrokenPromise::NotFinite, BrokenPromise::Outside, BrokenPromise::Messages]
        );
    }

    /// Promises must come from the technique's entry, for the path that ran. An unknown technique must count as failed.
    #[test]
    fn promises_are_those_of_the_entry() {
        let tail_off = Figures { tail: Some(5e-3), order_spread: Some(1e-6), ..Figures::default() };
        let of = |technique: &str, path: &str| {
            let row = row(1.0, Some(tail_off.clone()));
            broken(&CaseResult { technique: technique.into(), path: path.into(), ..row })
        };
        assert_eq!(of("avsm", "binned"), [BrokenPromise::Tail, BrokenPromise::Order]);
        assert_eq!(of("avsm", "interlock"), [BrokenPromise::Tail]);
        assert_eq!(of("avsm:detail=adaptive,curve=linear", "binned"), []);
        assert_eq!((of("psm", "fused"), of("psm", "raster")), (vec![BrokenPromise::Order], vec![]));
        assert_eq!(of("nobody", ""), [BrokenPromise::Failed]);
    }

    #[test]
    fn refusals_failures_and_silence_are_verdicts() {
        let ended = |outcome, reason: &str| CaseResult { outcome, reason: reason.into(), ..row(2.0, None) };
        let of = |row: CaseResult| verdicts(&[row]).remove(0);
        assert_eq!(of(ended(Outcome::Refused, "refused: needs rays")).verdict, "refused: needs rays");
        let failed = of(ended(Outcome::Failed, "device lost"));
        assert_eq!((failed.verdict.as_str(), failed.why.as_str()), ("breaks at 2", "device lost"));
        assert_eq!(failed.invariants, [BrokenPromise::Failed]);
        let silent = verdicts(&[row(1.0, off_by(0.0)), ended(Outcome::NoAnswer, "no answer within 9 s")]).remove(0);
        assert_eq!(silent.verdict, "holds up to 1; at 2 no answer within 9 s");
        assert_eq!((silent.breaks_at, silent.broken, silent.invariants), (None, vec![], vec![]));
        assert_eq!(of(ended(Outcome::NoAnswer, "no answer within 9 s")).verdict, "no answer within 9 s");
    }
}
