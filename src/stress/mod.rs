//! Stress for techniques: one number of a scene is swept from common values to extreme ones, and each technique is asked until
//! it breaks.
//!
//! [`cases`] says what is swept, [`ask`](fn@ask) what a technique answers at one of its values, [`Verdict`] how far it holds.
//! Every technique works in a process of its own ([`Worker`]), so that a driver that hangs or dies is a row too.
//! A [`round`](fn@round) of a soak is a random scene with random techniques, by its seed.

mod ask;
mod changes;
mod drawn;
mod meshes;
mod placed;
mod results;
mod round;
mod serve;
mod smoke;
mod soak;
mod strewn;
mod subject;
mod sweep;
mod verdict;
mod worker;

pub use ask::ask;
pub use results::{Asked, Figures, Outcome, Results, SCHEMA, Stressed};
pub use round::{Failure, Round, round};
pub use serve::{Job, Reply, serve};
pub use soak::{Life, Soaked, is_flat};
pub use subject::{SHUFFLES, Subject};
pub use sweep::Sweep;
pub(crate) use sweep::about;
pub(crate) use verdict::number;
pub use verdict::{Broken, Verdict, verdicts};
pub use worker::Worker;

use crate::scene::Scene;
use crate::{Error, Result};

/// A number of a scene that is swept.
#[derive(Clone, Copy)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// The content of the scene.
    pub about: &'static str,
    /// Which number, with its unit.
    pub swept: &'static str,
    /// From where it is common to where it is not.
    pub values: &'static [f64],
    /// The largest of them that a software device is asked; the others would take it minutes.
    pub most_on_cpu: f64,
    /// The scene at one of the values: the same each time.
    pub scene: fn(f64) -> Scene,
    /// Texels per side of maps, where these are what is swept; else they are the spec's.
    pub texels: Option<fn(f64) -> u32>,
}

impl Case {
    /// Defaults of cases.
    const USUAL: Self = Self {
        name: "",
        about: "",
        swept: "",
        values: &[],
        most_on_cpu: f64::INFINITY,
        scene: |_| strewn::scene(strewn::along(strewn::SLANTED), Vec::new(), Vec::new()),
        texels: None,
    };

    /// The case of that name.
    ///
    /// # Errors
    /// [`Error::Input`] that lists the names that there are.
    pub fn named(name: &str) -> Result<&'static Self> {
        cases().find(|case| case.name == name).ok_or_else(|| {
            let known: Vec<_> = cases().map(|case| case.name).collect();
            let shown = name.replace(char::is_control, "?");
            Error::input(shown, "no such case", format!("choose one of: {}", known.join(", ")))
        })
    }
}

/// All of them: smoke and hair, lights and views, meshes.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    [smoke::CASES, placed::CASES, meshes::CASES].into_iter().flatten()
}
