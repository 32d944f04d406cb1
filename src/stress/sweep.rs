//! The number that a sweep varies: one of a case's own scene, or of a scene that is given.

use super::changes::CHANGES;
use super::{Case, cases};
use crate::error::did_you_mean;
use crate::scene::{BUILT_IN, Motion, Scene, known};
use crate::{Error, Result};
use std::sync::Arc;

/// A scene that is given, and moves by itself, is taken as it is at this time, seconds.
const TIME_S: f64 = 20.0;

/// A number that is swept.
pub struct Sweep {
    /// A case's name, or `scene/change` for a scene.
    pub name: String,
    /// The scene that is given, as it was named; none of a case.
    pub given: Option<String>,
    /// From where it is common to where it is not.
    pub values: &'static [f64],
    /// As [`Case::most_on_cpu`].
    most_on_cpu: f64,
    /// Texels per side of maps, where these are swept.
    pub texels: Option<fn(f64) -> u32>,
    scene: Box<dyn Fn(f64) -> Scene>,
}

impl Sweep {
    /// The sweep of a case.
    pub fn of(case: &'static Case) -> Self {
        let Case { name, values, most_on_cpu, texels, scene, .. } = *case;
        Self { name: name.into(), given: None, values, most_on_cpu, texels, scene: Box::new(scene) }
    }

    /// All that a name stands for: a case, or the changes of a scene.
    ///
    /// # Errors
    /// [`Error::Input`] where it is neither, or the scene's file is none.
    pub fn named(name: &str) -> Result<Vec<Self>> {
        if let Ok(case) = Case::named(name) {
            return Ok(vec![Self::of(case)]);
        }
        let scene = Scene::load(name, TIME_S).map_err(|error| match error {
            Error::Input { name: given, cause, .. } if cause.starts_with("no such scene") => {
                let all: Vec<_> = cases().map(|case| case.name).collect();
                let meant = did_you_mean(name, all.iter().copied().chain(BUILT_IN));
                let way_out = format!("choose one of: {}; or give {}", all.join(", "), known());
                Error::input(given.replace(char::is_control, "?"), format!("no such case or scene{meant}"), way_out)
            }
            error => error,
        })?;
        let scene = Arc::new(Scene { motion: Motion::Still, ..scene });
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
        Ok(changes.map(change).collect())
    }

    /// The values that a device is asked.
    pub fn values(&self, is_software: bool) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().copied().filter(move |value| !is_software || *value <= self.most_on_cpu)
    }

    /// At one of the values: the same each time.
    pub fn scene(&self, value: f64) -> Scene {
        (self.scene)(value)
    }
}

/// What is in the scenes of a sweep, and which number is swept, by its name.
pub(crate) fn about(name: &str) -> Option<String> {
    let change = |name: &str| CHANGES.iter().find(|change| change.name == name);
    match name.rsplit_once('/') {
        Some((scene, name)) => change(name).map(|change| format!("{scene}; {}", change.swept)),
        None => Case::named(name).ok().map(|case| format!("{}; {}", case.about, case.swept)),
    }
}
