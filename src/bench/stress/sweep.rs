//! Sweeps of a number, in a case or as a change to a scene given by the user.

use super::changes::CHANGES;
use super::{StressCase, cases};
use crate::error::did_you_mean;
use crate::scene::{BUILT_IN, Loaded, Reserve, Scene, known, open};
use crate::{Error, Result};
use std::sync::Arc;

/// The time at which a given moving scene is captured, in seconds.
const TIME_S: f64 = 20.0;

/// A number that is swept.
pub struct Sweep {
    /// A case's name, or `scene/change` for a scene.
    pub name: String,
    /// The name of the given scene; `None` for a case.
    pub given: Option<String>,
    /// Values of the number, from common to extreme.
    pub values: &'static [f64],
    /// See [`StressCase::most_on_cpu`].
    most_on_cpu: f64,
    /// Texels per side of maps at a value, if these are swept.
    pub texels: Option<fn(f64) -> u32>,
    scene: Box<dyn Fn(f64) -> Scene>,
}

impl Sweep {
    /// The sweep of a case.
    pub fn of(case: &'static StressCase) -> Self {
        let StressCase { name, values, most_on_cpu, texels, scene, .. } = *case;
        Self { name: name.into(), given: None, values, most_on_cpu, texels, scene: Box::new(scene) }
    }

    /// Returns all sweeps for a name: the sweep of a case, or one per change of a scene; and notes about the scene's files.
    ///
    /// # Errors
    /// [`Error::Usage`] if the name is neither a case nor a scene, [`Error::Input`] if the scene's file is faulty.
    pub fn named(name: &str) -> Result<(Vec<Self>, Vec<String>)> {
        if let Ok(case) = StressCase::named(name) {
            return Ok((vec![Self::of(case)], Vec::new()));
        }
        let Loaded { scene, notes, .. } = open(name, TIME_S, None).map_err(|error| match error {
            Error::Usage { name: given, cause, .. } if cause.starts_with("no such scene") => {
                let all: Vec<_> = cases().map(|case| case.name).collect();
                let meant = did_you_mean(name, all.iter().copied().chain(BUILT_IN));
                let way_out = format!("choose one of: {}; or give {}", all.join(", "), known());
                Error::usage(given.replace(char::is_control, "?"), format!("no such case or scene{meant}"), way_out)
            }
            error => error,
        })?;
        let scene = Arc::new(Scene { reserve: Reserve::default(), ..scene });
        let changes = CHANGES.iter().filter(|change| change.of_any || !scene.casters().is_empty());
        let change = |change: &'static super::changes::Change| {
            let scene = scene.clone();
            Self {
                name: format!("{}/{}", scene.name, change.name),
                given: Some(name.into()),
                values: change.values,
                most_on_cpu: f64::INFINITY,
                texels: None,
                scene: Box::new(move |value| (change.changed)(&scene, value)),
            }
        };
        Ok((changes.map(change).collect(), notes))
    }

    /// Returns the values to run on a device.
    pub fn values(&self, is_software: bool) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().copied().filter(move |value| !is_software || *value <= self.most_on_cpu)
    }

    /// Builds the scene at one of the values, always the same.
    pub fn scene(&self, value: f64) -> Scene {
        (self.scene)(value)
    }
}

/// Describes a sweep by its name: the content of its scenes and the number that is swept.
pub(crate) fn about(name: &str) -> Option<String> {
    let change = |name: &str| CHANGES.iter().find(|change| change.name == name);
    match name.rsplit_once('/') {
        Some((scene, name)) => change(name).map(|change| format!("{scene}; {}", change.swept)),
        None => StressCase::named(name).ok().map(|case| format!("{}; {}", case.about, case.swept)),
    }
}
