//! How far a technique holds in a case: what its answers must be, and where they first are not.

use super::results::{Figures, Outcome, Stressed};
use serde::{Deserialize, Serialize};

/// What may be said of a technique's answers. What is absent is the method's to say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Allowed {
    /// Mean absolute error on the rays of texels, against the filtered truth.
    map_mean: Option<f64>,
    /// By how much an answer behind all smoke may be off the product of all.
    tail: Option<f64>,
    /// By how much an answer may rise along a ray.
    rise: Option<f64>,
    /// By how much answers may differ with the casters' order.
    order: Option<f64>,
    /// Root mean square of a step, more than the truth's.
    step: Option<f64>,
    /// Leaks and false shadows outside the boundary of opaque shadows.
    wrong: Option<u64>,
}

/// Rounding of a few thousand sums of floats: a fortieth of what eight bits tell apart.
const ROUNDING: f64 = 1e-4;

/// What a filter in hardware may rise by: it knows a place in a texel to 8 bits, across and up, and rounding decides which of two.
const FILTERED: f64 = 2.0 / 256.0;

/// Of the technique of a row.
fn allowed(row: &Stressed) -> Allowed {
    let (name, keys) = row.technique.split_once(':').unwrap_or((&row.technique, ""));
    let exact = Some(0.0);
    let sorted = exact.filter(|_| !keys.contains("curve=linear"));
    let usual = Allowed { rise: Some(ROUNDING), wrong: Some(0), step: Some(0.02), ..Allowed::default() };
    // Knows no depth: before all smoke it is as wrong as behind, and changes by as much in a step.
    let blind = Allowed { wrong: None, step: None, ..usual };
    let in_hardware = Allowed { rise: Some(ROUNDING + FILTERED), ..usual };
    match (name, row.path.as_str()) {
        ("uncompressed", _) => Allowed { map_mean: Some(1e-4), tail: Some(1e-3), order: Some(ROUNDING), ..usual },
        // Straight lines between nodes, where smoke fades by an exponential.
        // What is asked about are the rays of an even map's texels, which these have not; that each of theirs has the tail, the
        // twins say.
        ("avsm", _) if ["detail=adaptive", "texel=area"].iter().any(|key| keys.contains(key)) => {
            Allowed { order: sorted, ..usual }
        }
        // A byte a node, rounded once.
        ("avsm", "two-pass" | "binned") if keys.contains("storage=tight") => {
            Allowed { tail: Some(1e-2), order: sorted, ..usual }
        }
        ("avsm", _) if keys.contains("storage=tight") => Allowed { tail: Some(1e-2), ..usual },
        ("avsm", _) if keys.contains("curve=linear") => Allowed { tail: Some(1e-3), ..usual },
        ("avsm", "two-pass" | "binned") => Allowed { map_mean: Some(1e-2), tail: Some(1e-3), order: exact, ..usual },
        // One pass inserts in the order of the casters' middles.
        ("avsm", _) => Allowed { map_mean: Some(2e-2), tail: Some(1e-3), ..usual },
        // A sphere is in one slice, so that its error is as large as itself; eight bits are rounded once.
        ("psm", "fused") => Allowed { tail: Some(1e-2), order: exact, ..in_hardware },
        // Blending rounds to eight bits at each sphere.
        ("translucency-map", "raster") => blind,
        ("psm", "raster") => in_hardware,
        ("beer-shadow-map", _) => usual,
        ("translucency-map", _) => Allowed { tail: Some(1e-2), ..blind },
        ("shadow-map" | "ray-query" | "voxelized" | "voxel-grid", _) => {
            Allowed { wrong: Some(0), order: exact, ..Allowed::default() }
        }
        _ => Allowed::default(),
    }
}

/// What broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Broken {
    /// Answers that are infinite or not a number.
    NotFinite,
    /// Answers below 0 or above 1.
    Outside,
    /// Light that rises along its ray.
    Rising,
    /// The tail is not the product of all.
    Tail,
    /// Answers that depend on the casters' order.
    Order,
    /// The validation layer said something.
    Messages,
    /// A call failed, or the process died.
    Failed,
    /// No answer in time.
    NoAnswer,
    /// The mean error is above the threshold.
    Error,
    /// Leaks or false shadows outside the boundary.
    Wrong,
    /// Steps from frame to frame are above the threshold.
    Step,
}

impl Broken {
    /// Whether nothing may do this, however extreme the scene: what a method's own limits cannot excuse.
    pub fn is_invariant(self) -> bool {
        !matches!(self, Self::NoAnswer | Self::Error | Self::Wrong | Self::Step)
    }

    /// In few words, with the figure.
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
            Self::NoAnswer => "no answer in time".into(),
            Self::Error => {
                format!("mean error {:.1e}", most(figures.map.and_then(|m| m.error).map(|e| e.mean_abs)))
            }
            Self::Wrong => format!("{} leaks or false shadows", figures.wrong().unwrap_or(0)),
            Self::Step => format!("step {:.1e}", most(figures.step_rms)),
        }
    }
}

/// All that a row breaks.
pub(super) fn broken(row: &Stressed) -> Vec<Broken> {
    let figures = match (row.outcome, &row.figures) {
        (Outcome::Refused, _) => return Vec::new(),
        (Outcome::NoAnswer, _) => return vec![Broken::NoAnswer],
        (Outcome::Failed, _) | (_, None) => return vec![Broken::Failed],
        (Outcome::Answered, Some(figures)) => figures,
    };
    let allowed = allowed(row);
    // A figure that is not a number is no small one.
    let above =
        |figure: Option<f64>, most: Option<f64>| figure.zip(most).is_some_and(|(f, most)| f.is_nan() || f > most);
    let map_mean = figures.map.and_then(|map| map.error).map(|error| error.mean_abs);
    [
        (figures.not_finite > 0, Broken::NotFinite),
        (figures.outside > 0, Broken::Outside),
        (above(figures.rise, allowed.rise), Broken::Rising),
        (above(figures.tail, allowed.tail), Broken::Tail),
        (above(figures.order_spread, allowed.order), Broken::Order),
        (figures.messages > 0, Broken::Messages),
        (above(map_mean, allowed.map_mean), Broken::Error),
        (figures.wrong().zip(allowed.wrong).is_some_and(|(count, most)| count > most), Broken::Wrong),
        (above(figures.step_rms, allowed.step), Broken::Step),
    ]
    .into_iter()
    .filter_map(|(is_broken, what)| is_broken.then_some(what))
    .collect()
}

/// All that a row breaks that nothing may break, in words.
pub(super) fn broken_invariants(row: &Stressed) -> Vec<String> {
    let figures = row.figures.clone().unwrap_or_default();
    broken(row).into_iter().filter(|broken| broken.is_invariant()).map(|broken| broken.words(&figures)).collect()
}

/// How far a technique holds in a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// [`super::Case::name`].
    pub case: String,
    /// Its spec, without what is the default.
    pub technique: String,
    /// `holds`, `holds up to X`, `breaks at X` where that is the first, or `refused: …`.
    pub verdict: String,
    /// The last value before the first at which something breaks; absent where it breaks at once or is refused.
    pub holds_up_to: Option<f64>,
    /// The first value at which something breaks.
    pub breaks_at: Option<f64>,
    /// What breaks there.
    pub broken: Vec<Broken>,
    /// The same with its figures, or why there was no answer.
    pub why: String,
    /// What breaks that nothing may break, at any value.
    pub invariants: Vec<Broken>,
    /// Figures at the last value at which it holds; where it holds at none, at the first.
    pub figures: Option<Figures>,
}

impl Verdict {
    /// From the rows of a technique in a case, in the order of its values.
    pub(super) fn of(rows: &[&Stressed]) -> Option<Self> {
        let first = rows.first()?;
        let found: Vec<_> = rows.iter().map(|row| broken(row)).collect();
        let breaks = found.iter().position(|broken| !broken.is_empty());
        let refused = rows.iter().position(|row| row.outcome == Outcome::Refused);
        let end = breaks.unwrap_or(rows.len());
        let held = rows[..end].iter().rev().find(|row| row.outcome == Outcome::Answered);
        let verdict = match (held, breaks) {
            (Some(row), None) => match refused {
                Some(at) => {
                    format!("holds up to {}; at {} {}", number(row.value), number(rows[at].value), rows[at].reason)
                }
                None => "holds".into(),
            },
            (Some(row), Some(_)) => format!("holds up to {}", number(row.value)),
            (None, Some(at)) => format!("breaks at {}", number(rows[at].value)),
            (None, None) => refused.map_or_else(String::new, |at| rows[at].reason.clone()),
        };
        let why = breaks.map_or_else(String::new, |at| {
            let words = |broken: &Broken| match &rows[at].figures {
                Some(figures) => broken.words(figures),
                None => rows[at].reason.clone(),
            };
            found[at].iter().map(words).collect::<Vec<_>>().join(", ")
        });
        let mut invariants: Vec<Broken> = Vec::new();
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

/// As it is written in the table of cases.
pub(crate) fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if plain { format!("{value}") } else { format!("{value:e}") }
}

/// One a case and technique, in the order of the rows.
pub fn verdicts(rows: &[Stressed]) -> Vec<Verdict> {
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
    use super::super::results::Asked;
    use super::*;
    use crate::measure::PointError;

    fn row(value: f64, figures: Option<Figures>) -> Stressed {
        Stressed {
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
        Some(Figures { map: Some(Asked { error: Some(error), points: 9 }), ..Figures::default() })
    }

    #[test]
    fn it_holds_up_to_the_last_value_before_the_first_that_breaks() {
        let rows = [row(1.0, off_by(1e-3)), row(10.0, off_by(1e-3)), row(100.0, off_by(0.5)), row(1e6, off_by(0.0))];
        let [verdict] = &verdicts(&rows)[..] else { panic!("one pair") };
        assert_eq!(
            (verdict.verdict.as_str(), verdict.holds_up_to, verdict.breaks_at),
            ("holds up to 10", Some(10.0), Some(100.0))
        );
        assert_eq!((&verdict.broken[..], verdict.why.as_str()), (&[Broken::Error][..], "mean error 5.0e-1"));
        assert_eq!(verdict.invariants, []);
        assert_eq!(verdicts(&rows[..2])[0].verdict, "holds");
        assert_eq!(verdicts(&rows[2..])[0].verdict, "breaks at 100");
    }

    /// A NaN is no figure below a threshold, and what comes after the first break counts for the invariants.
    #[test]
    fn what_is_not_a_number_breaks() {
        let spread = |order_spread| Some(Figures { order_spread: Some(order_spread), ..Figures::default() });
        assert_eq!(broken(&row(1.0, spread(0.0))), []);
        assert_eq!(broken(&row(1.0, spread(1e-7))), [Broken::Order]);
        assert_eq!(broken(&row(1.0, spread(f64::NAN))), [Broken::Order]);
        let late = Figures { not_finite: 1, ..Figures::default() };
        let rows = [row(1.0, off_by(0.5)), row(2.0, Some(late))];
        assert_eq!(verdicts(&rows)[0].invariants, [Broken::NotFinite]);
    }

    #[test]
    fn refusals_failures_and_silence_are_verdicts() {
        let ended = |outcome, reason: &str| Stressed { outcome, reason: reason.into(), ..row(2.0, None) };
        let of = |row: Stressed| verdicts(&[row]).remove(0);
        assert_eq!(of(ended(Outcome::Refused, "refused: needs rays")).verdict, "refused: needs rays");
        let failed = of(ended(Outcome::Failed, "device lost"));
        assert_eq!((failed.verdict.as_str(), failed.why.as_str()), ("breaks at 2", "device lost"));
        assert_eq!(failed.invariants, [Broken::Failed]);
        let silent = verdicts(&[row(1.0, off_by(0.0)), ended(Outcome::NoAnswer, "no answer within 9 s")]).remove(0);
        assert_eq!((silent.verdict.as_str(), silent.why.as_str()), ("holds up to 1", "no answer within 9 s"));
        assert_eq!(silent.invariants, []);
    }
}
