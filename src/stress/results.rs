//! The result of a run of stress: `stress.json`.

use super::verdict::Verdict;
use crate::measure::{DeviceFacts, PointError};
use serde::{Deserialize, Serialize};

/// Version of `stress.json`.
pub const SCHEMA: u32 = 1;

/// A whole run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The program's version.
    pub gobo: String,
    /// As it was given.
    pub command: String,
    /// Where it ran.
    pub device: DeviceFacts,
    /// How long a row may take, seconds.
    pub limit_s: f64,
    /// How far each technique holds in each case.
    pub verdicts: Vec<Verdict>,
    /// One per case, value and technique, in the order they were asked.
    pub rows: Vec<Stressed>,
}

/// How a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It answered.
    Answered,
    /// The device or the scene lacks something that it needs.
    Refused,
    /// A call failed, or the process died.
    Failed,
    /// It took longer than it may.
    NoAnswer,
}

/// A technique at one value of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stressed {
    /// [`super::Case::name`].
    pub case: String,
    /// The value of the setting that is swept.
    pub value: f64,
    /// Its spec, without defaults.
    pub technique: String,
    /// The path that ran.
    pub path: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Why, where it did not answer.
    pub reason: String,
    /// Where it answered.
    pub figures: Option<Figures>,
}

/// Figures of its answers. Figures that the technique or the scene does not have are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// On the rays of texels, against the filtered truth of smoke.
    pub map: Option<Asked>,
    /// In space, against the truth there.
    pub space: Option<Asked>,
    /// On meshes.
    pub surface: Option<Asked>,
    /// Answers that are infinite or not a number.
    pub not_finite: u64,
    /// Answers below 0 or above 1 by more than rounding.
    pub outside: u64,
    /// The most by which an answer rises along a texel's ray.
    pub rise: Option<f64>,
    /// The most by which an answer behind all smoke is off the product of all.
    pub tail: Option<f64>,
    /// The most by which answers differ where the same casters come in another order.
    pub order_spread: Option<f64>,
    /// Root mean square of how much more than the truth answers change in a tiny motion.
    pub step_rms: Option<f64>,
    /// Messages of the validation layer meanwhile.
    pub messages: u64,
}

/// Answers of one kind of points, the finite ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// Errors of all of them.
    pub error: Option<PointError>,
    /// How many were asked.
    pub points: u64,
}

impl Asked {
    /// Leaks and false shadows beyond the technique's own resolution of opaque shadows; none where nothing opaque casts.
    pub fn wrong(&self) -> Option<u64> {
        let beyond = self.error?.beyond()?;
        Some(beyond.leaks + beyond.false_shadows)
    }
}

impl Figures {
    /// The same in space and on surfaces.
    pub fn wrong(&self) -> Option<u64> {
        [self.space, self.surface].into_iter().flatten().filter_map(|asked| asked.wrong()).reduce(|a, b| a + b)
    }
}
