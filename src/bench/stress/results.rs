//! The result of a stress run: `stress.json`.

use super::verdict::Verdict;
use crate::bench::{DeviceFacts, PointError, SeenError};
use serde::{Deserialize, Serialize};

/// Version of `stress.json`.
pub const SCHEMA: u32 = 1;

/// A whole run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Schema version, [`SCHEMA`].
    pub schema: u32,
    /// The program's version.
    pub gobo: String,
    /// The command line as given.
    pub command: String,
    /// The device that the run used.
    pub device: DeviceFacts,
    /// Time limit per row, in seconds.
    pub limit_s: f64,
    /// How far each technique holds in each case.
    pub verdicts: Vec<Verdict>,
    /// One row per case, value and technique, in the order in which they ran.
    pub rows: Vec<CaseResult>,
}

/// How a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The technique answered.
    Answered,
    /// The device or the scene lacks something that the technique needs.
    Refused,
    /// A call failed, or the process died.
    Failed,
    /// The row took longer than the time limit.
    NoAnswer,
}

/// A technique at one value of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Name of the case, [`super::StressCase::name`].
    pub case: String,
    /// The value of the setting that is swept.
    pub value: f64,
    /// The technique's spec, without defaults.
    pub technique: String,
    /// The path that ran.
    pub path: String,
    /// How it ended.
    pub outcome: Outcome,
    /// The reason, if the technique did not answer.
    pub reason: String,
    /// Figures, if the technique answered.
    pub figures: Option<Figures>,
}

/// Figures of a technique's answers. Figures that do not apply to the technique or the scene are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Error at points on the rays of texels, against the filtered truth.
    pub map: Option<ErrorSummary>,
    /// Error at points in space, against the truth.
    pub space: Option<ErrorSummary>,
    /// Error at points on meshes, against the truth.
    pub surface: Option<ErrorSummary>,
    /// Error at points that the camera sees; absent if no light is sent to it or an answer is not finite, and in older
    /// files.
    #[serde(default)]
    pub seen: Option<SeenError>,
    /// Number of answers that are infinite or not a number.
    pub not_finite: u64,
    /// Number of answers below 0 or above 1 by more than rounding.
    pub outside: u64,
    /// The largest rise of an answer along a texel's ray.
    pub rise: Option<f64>,
    /// The largest error of an answer behind all smoke.
    pub tail: Option<f64>,
    /// The largest difference between answers for different orders of the same casters.
    pub order_spread: Option<f64>,
    /// Root mean square of how much more answers change in a tiny motion than the truth does.
    pub step_rms: Option<f64>,
    /// Number of messages of the validation layer during the row.
    pub messages: u64,
}

/// Summary of the finite answers at points of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Errors of the finite answers.
    pub error: Option<PointError>,
    /// Number of finite answers.
    pub points: u64,
}

impl ErrorSummary {
    /// Returns the number of leaks and false shadows beyond the technique's own resolution of opaque shadows; `None` if
    /// nothing opaque casts.
    pub fn wrong(&self) -> Option<u64> {
        let beyond = self.error?.beyond()?;
        Some(beyond.leaks + beyond.false_shadows)
    }
}

impl Figures {
    /// Returns the number of leaks and false shadows in space and on surfaces together, as in [`ErrorSummary::wrong`].
    pub fn wrong(&self) -> Option<u64> {
        [self.space, self.surface].into_iter().flatten().filter_map(|asked| asked.wrong()).reduce(|a, b| a + b)
    }
}
