//! Animations of the built-in scenes and of files.

use super::{Animated, SceneParts};
use crate::scene::built_in::{courtyard, courtyard_lights, emitters, fountain, hair, lantern};
use crate::scene::{self, Animation, Light, Scene, Smoke, check_time};
use crate::{Error, Result};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Returns the animation of the built-in scene with this name; `None` if nothing in it moves.
pub(super) fn animation(name: &str, scene: &Scene) -> Option<Arc<dyn Animated>> {
    Some(match name.split(':').next()? {
        "three-emitters" => Arc::new(ThreeEmitters::default()),
        "lantern" => Arc::new(Lantern::default()),
        "hair" => Arc::new(Hair),
        "courtyard" => Arc::new(Courtyard),
        "fountain" => Arc::new(Fountain(scene::Fountain::new(scene.particles.len() as u32))),
        _ => return None,
    })
}

/// The smoke of `three-emitters`. Each call to [`Animated::at`] continues from the positions of the previous call.
#[derive(Default)]
struct ThreeEmitters(Mutex<Smoke>);

/// The smoke and the lights of `lantern`.
#[derive(Default)]
struct Lantern(Mutex<Smoke>);

/// The light of `hair`.
#[derive(Debug)]
struct Hair;

/// The lights of `courtyard`, however many it has.
#[derive(Debug)]
pub(super) struct Courtyard;

/// The particles of `fountain`.
#[derive(Debug)]
pub(super) struct Fountain(pub scene::Fountain);

impl Animated for ThreeEmitters {
    fn at(&self, _: &Scene, time_s: f64) -> Result<SceneParts> {
        let mut smoke = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(SceneParts { particles: Some(emitters::particles(time_s, &mut smoke)?), ..SceneParts::default() })
    }
}

impl Animated for Lantern {
    fn at(&self, _: &Scene, time_s: f64) -> Result<SceneParts> {
        let mut smoke = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let particles = Some(lantern::particles(time_s, &mut smoke)?);
        Ok(SceneParts { particles, lights: Some(lantern::lights(time_s)), ..SceneParts::default() })
    }
}

impl Animated for Hair {
    fn at(&self, _: &Scene, time_s: f64) -> Result<SceneParts> {
        Ok(SceneParts { lights: Some(hair::lights(time_s)?), ..SceneParts::default() })
    }
}

impl Animated for Courtyard {
    fn at(&self, scene: &Scene, time_s: f64) -> Result<SceneParts> {
        let lights = courtyard::lights_at(scene.lights.len(), time_s)?;
        Ok(SceneParts { lights: Some(lights), ..SceneParts::default() })
    }
}

impl Animated for Fountain {
    fn at(&self, _: &Scene, time_s: f64) -> Result<SceneParts> {
        Ok(SceneParts { particles: Some(fountain::particles(&self.0, time_s)?), ..SceneParts::default() })
    }
}

impl Animated for Animation {
    fn at(&self, scene: &Scene, time_s: f64) -> Result<SceneParts> {
        check_time(&scene.name, time_s)?;
        let mut parts = SceneParts::default();
        if self.has_sequences() {
            let (particles, volumes) = self.at(time_s)?;
            (parts.particles, parts.volumes) = (Some(particles), Some(volumes));
        }
        if self.moves_meshes() {
            let mut meshes = scene.meshes.clone();
            self.show_meshes(&mut meshes, time_s)?;
            parts.meshes = Some(meshes);
        }
        Ok(parts)
    }
}

// `Debug` omits the current state of the smoke, which does not distinguish one motion from another.
impl fmt::Debug for ThreeEmitters {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("ThreeEmitters")
    }
}

impl fmt::Debug for Lantern {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("Lantern")
    }
}

/// Returns `count` lights of `courtyard` at a time; `scene` is used in error messages.
///
/// # Errors
/// [`Error::Usage`] if the number or the time is out of range.
pub(super) fn courtyard_lights(scene: &str, count: usize, time_s: f64) -> Result<Vec<Light>> {
    if !(1..=courtyard_lights::MOST).contains(&count) {
        let cause = format!("{count} lights, and there are 1 to {}", courtyard_lights::MOST);
        return Err(Error::usage(scene, cause, "choose another number"));
    }
    courtyard::lights_at(count, time_s)
}
