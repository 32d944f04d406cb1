//! Changes to a loaded scene: another camera, another light direction, thicker or thinner smoke.

use crate::scene::{Camera, Light, LightKind, Scene};
use crate::{Error, Result};
use glam::DVec3;

/// A change to a scene, as requested by a user; fields that are `None` keep their values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneChange {
    /// Camera position, in world units.
    pub eye: Option<DVec3>,
    /// Camera target, in world units.
    pub target: Option<DVec3>,
    /// Direction in which the first directional or spot light shines; any length above 0.
    pub direction: Option<DVec3>,
    /// Factor of the optical depth of smoke, hair and splats, ≥ 0.
    pub extinction: f64,
}

impl Default for SceneChange {
    fn default() -> Self {
        Self { eye: None, target: None, direction: None, extinction: 1.0 }
    }
}

impl SceneChange {
    /// Returns the scene with this change applied.
    ///
    /// # Errors
    /// [`Error::Input`] if no light of the scene has a direction, a number is out of range, or the camera is at its own target or
    /// looks along its up vector.
    pub fn of(&self, scene: &Scene) -> Result<Scene> {
        let (camera, lights) = self.aimed(scene)?;
        if !(self.extinction >= 0.0 && self.extinction.is_finite()) {
            let (cause, way_out) = ("an extinction below 0 or without bound", "give a number of 0 or more");
            return Err(Error::input(scene.name.clone(), cause, way_out));
        }
        let mut changed = scene.clone();
        (changed.camera, changed.lights) = (camera, lights);
        if self.extinction != 1.0 {
            thicken(&mut changed, self.extinction);
        }
        Ok(changed)
    }

    /// Returns only the camera and the lights of the changed scene.
    ///
    /// # Errors
    /// Same as [`SceneChange::of`], except for extinction.
    pub fn aimed(&self, scene: &Scene) -> Result<(Camera, Vec<Light>)> {
        let fail = |cause: &str, way_out: &str| Err(Error::input(scene.name.clone(), cause, way_out));
        let (mut camera, mut lights) = (scene.camera, scene.lights.clone());
        camera.position = self.eye.unwrap_or(camera.position);
        camera.target = self.target.unwrap_or(camera.target);
        let forward = camera.target - camera.position;
        if !(forward.cross(camera.up).length_squared() > 0.0 && forward.is_finite()) {
            return fail("the camera looks along its up, or nowhere", "move it, or what it looks at");
        }
        if let Some(direction) = self.direction {
            if !(direction.length() > 0.0 && direction.is_finite()) {
                return fail("a light's direction of no length", "give one");
            }
            // If lights are listed once per color, turn the light in all colors.
            let each = (lights.len() / scene.colors()).max(1);
            let turned = lights.chunks_mut(each).map(|lights| turn(lights, direction.normalize())).collect::<Vec<_>>();
            if !turned.contains(&true) {
                return fail("none of its lights has a direction", "leave the direction out, or name another scene");
            }
        }
        Ok((camera, lights))
    }
}

/// Turns the first light that has a direction; returns false if none has one.
fn turn(lights: &mut [Light], to: DVec3) -> bool {
    let mut directions = lights.iter_mut().filter_map(|light| match &mut light.kind {
        LightKind::Directional { direction } | LightKind::Spot { direction, .. } => Some(direction),
        LightKind::Point { .. } | LightKind::Virtual { .. } => None,
    });
    directions.next().map(|direction| *direction = to).is_some()
}

fn thicken(scene: &mut Scene, factor: f64) {
    // Multiplies the optical depth −ln(1 − opacity) by the factor.
    let opacity = |opacity: f32| (1.0 - (1.0 - f64::from(opacity)).powf(factor)) as f32;
    scene
        .particles
        .iter_mut()
        .for_each(|p| p.extinction = (f64::from(p.extinction) * factor).min(f32::MAX.into()) as f32);
    scene.strands.iter_mut().for_each(|strand| strand.opacity = opacity(strand.opacity));
    scene.splats.iter_mut().for_each(|splat| splat.opacity = opacity(splat.opacity));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;

    #[test]
    fn only_what_is_said_changes() {
        let scene = on_the_axis(&[(0.0, 1.0, 2.0)]);
        assert_eq!(SceneChange::default().of(&scene).expect("nothing"), scene);
        let change = SceneChange {
            eye: Some(DVec3::X * 3.0),
            direction: Some(DVec3::X * 2.0),
            extinction: 0.5,
            ..Default::default()
        };
        let changed = change.of(&scene).expect("valid");
        assert_eq!((changed.camera.position, changed.camera.target), (DVec3::X * 3.0, scene.camera.target));
        assert_eq!(changed.lights[0].kind, LightKind::Directional { direction: DVec3::X });
        assert_eq!((changed.particles[0].extinction, changed.particles[0].radius), (1.0, 1.0));
    }

    /// Two layers of half the optical depth must transmit as much light as one layer of the full optical depth: (1 − a)² = 1 − opacity.
    #[test]
    fn opacity_follows_the_optical_depth() {
        let mut scene = on_the_axis(&[]);
        let strand = crate::scene::Strand { start: [0.0; 3], radius: 0.1, end: [1.0; 3], opacity: 0.75 };
        scene.strands.push(strand);
        let half = SceneChange { extinction: 0.5, ..Default::default() }.of(&scene).expect("valid");
        assert!((half.strands[0].opacity - 0.5).abs() < 1e-6);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let mut scene = on_the_axis(&[]);
        let told = |scene: &Scene, change: SceneChange| change.of(scene).expect_err("refused").to_string();
        let none = SceneChange::default();
        for (change, words) in [
            (SceneChange { eye: Some(scene.camera.target), ..none }, "nowhere"),
            (SceneChange { direction: Some(DVec3::ZERO), ..none }, "no length"),
            (SceneChange { extinction: -1.0, ..none }, "below 0"),
            (SceneChange { extinction: f64::NAN, ..none }, "below 0"),
        ] {
            assert!(told(&scene, change).contains(words), "{change:?}");
        }
        scene.lights[0].kind = LightKind::Point { position: DVec3::Z };
        assert!(told(&scene, SceneChange { direction: Some(DVec3::X), ..none }).contains("none of its lights"));
    }
}
