//! Stress tests: one number of a scene is swept from common values to extreme ones, to find where each technique breaks.
//!
//! [`cases`] lists the numbers that are swept, [`ask`](fn@ask) measures a technique at one value, and a [`Verdict`] states how far it keeps
//! its promises. Techniques run in a separate process ([`Worker`]), so that a driver that hangs or dies also gives a row. A
//! [`round`](fn@round) of a soak uses a random scene and random techniques, determined by its seed.

mod case_truth;
mod changes;
mod evaluate;
mod light_cases;
mod meshes;
mod random_round;
mod results;
mod round;
mod run;
mod scene_builders;
mod smoke;
mod soak;
mod sweep;
mod verdict;
mod worker;
mod worker_protocol;

pub use case_truth::{SHUFFLES, Subject};
pub use evaluate::ask;
pub use results::{CaseResult, ErrorSummary, Figures, Outcome, Results, SCHEMA};
pub use round::{Failure, Round, round};
pub use run::{StressPlan, run};
pub use soak::{Life, Soaked, is_flat, soak};
pub use sweep::Sweep;
pub(crate) use sweep::about;
pub(crate) use verdict::number;
pub use verdict::{BrokenPromise, Verdict, verdicts};
pub use worker::Worker;
pub use worker_protocol::{Job, Reply, serve};

use crate::scene::Scene;
use crate::{Error, Result};

/// A kind of scene with a number that is swept.
#[derive(Clone, Copy)]
pub struct StressCase {
    /// Its name.
    pub name: &'static str,
    /// The content of the scene.
    pub about: &'static str,
    /// Description of the number that is swept, with its unit.
    pub swept: &'static str,
    /// Values of the number, from common to extreme.
    pub values: &'static [f64],
    /// The largest value to run on a software device, where larger values would take minutes.
    pub most_on_cpu: f64,
    /// Builds the scene at one of the values, always the same.
    pub scene: fn(f64) -> Scene,
    /// Texels per side of maps at a value, if these are swept; otherwise the spec decides.
    pub texels: Option<fn(f64) -> u32>,
}

impl StressCase {
    /// Default values for cases.
    const USUAL: Self = Self {
        name: "",
        about: "",
        swept: "",
        values: &[],
        most_on_cpu: f64::INFINITY,
        scene: |_| scene_builders::scene(scene_builders::along(scene_builders::SLANTED), Vec::new(), Vec::new()),
        texels: None,
    };

    /// Returns the case with that name.
    ///
    /// # Errors
    /// [`Error::Usage`], listing all names, if there is none.
    pub fn named(name: &str) -> Result<&'static Self> {
        cases().find(|case| case.name == name).ok_or_else(|| {
            let known: Vec<_> = cases().map(|case| case.name).collect();
            let shown = name.replace(char::is_control, "?");
            Error::usage(shown, "no such case", format!("choose one of: {}", known.join(", ")))
        })
    }
}

/// Returns all cases: smoke and hair, lights and views, meshes.
pub fn cases() -> impl Iterator<Item = &'static StressCase> {
    [smoke::CASES, light_cases::CASES, meshes::CASES].into_iter().flatten()
}
