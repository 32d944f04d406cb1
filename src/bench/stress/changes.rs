//! Scene parameters that can be swept in a scene given by the user.

use super::scene_builders::{changed, denser, step};
use crate::reference::truth::bounds;
use crate::scene::{LightKind, Particle, Scene};
use glam::DVec3;

/// A scene parameter that the stress test varies.
pub(super) struct Change {
    pub name: &'static str,
    /// Description of the number that is swept.
    pub swept: &'static str,
    pub values: &'static [f64],
    /// Whether the change also applies to scenes of meshes alone.
    pub of_any: bool,
    pub changed: fn(&Scene, f64) -> Scene,
}

/// All parameters that can be swept in a given scene.
pub(super) const CHANGES: &[Change] = &[
    Change { name: "as-it-is", swept: "nothing", values: &[1.0], of_any: true, changed: |scene, _| scene.clone() },
    Change {
        name: "extinction",
        swept: "factor of all extinctions and of hairs' optical depths",
        values: &[1.0, 1e2, 1e4, 1e6, 1e38],
        of_any: false,
        changed: thicker,
    },
    Change {
        name: "extinction-low",
        swept: "factor of all extinctions and of hairs' optical depths",
        values: &[1.0, 1e-2, 1e-4, 1e-6],
        of_any: false,
        changed: thicker,
    },
    Change {
        name: "extinction-mixed",
        swept: "extinction of every other caster, the rest have 0",
        values: &[1.0, 1e3, 1e6, 1e38],
        of_any: false,
        changed: |scene, extinction| {
            let chosen = |i: usize| if i.is_multiple_of(2) { extinction } else { 0.0 };
            let particle = |i: usize, p: &Particle| Particle { extinction: chosen(i) as f32, ..*p };
            let mut scene = Scene { particles: changed(scene.particles.clone(), particle), ..scene.clone() };
            for (i, strand) in scene.strands.iter_mut().enumerate() {
                strand.opacity = -(-chosen(i) * 2.0 * f64::from(strand.radius)).exp_m1() as f32;
            }
            scene
        },
    },
    Change {
        name: "origin",
        swept: "how far from where it is, with its lights and its camera, diagonals of its casters",
        values: &[0.0, 1e2, 1e3, 1e4, 1e5, 1e6],
        of_any: true,
        changed: |scene, distance| {
            let diagonal = bounds(scene).map_or(1.0, |[low, high]| (high - low).length());
            moved(scene, distance * diagonal * DVec3::new(0.8, -0.5, 0.33))
        },
    },
    Change {
        name: "radius-small",
        swept: "factor of all radii",
        values: &[1.0, 1e-1, 1e-2, 1e-3],
        of_any: false,
        changed: wider,
    },
    Change {
        name: "radius-large",
        swept: "factor of all radii",
        values: &[1.0, 1e1, 1e2],
        of_any: false,
        changed: wider,
    },
];

fn thicker(scene: &Scene, factor: f64) -> Scene {
    let mut scene = Scene { particles: changed(scene.particles.clone(), |_, p| denser(p, factor)), ..scene.clone() };
    for strand in &mut scene.strands {
        // Raises the transmittance to the power of the factor.
        strand.opacity = -(factor * f64::from(-strand.opacity).ln_1p()).exp_m1() as f32;
    }
    scene
}

fn wider(scene: &Scene, factor: f64) -> Scene {
    let mut scene = scene.clone();
    scene.particles.iter_mut().for_each(|p| p.radius *= factor as f32);
    scene.strands.iter_mut().for_each(|s| s.radius *= factor as f32);
    scene
}

/// Moves the whole scene, with lights and camera; positions of casters are rounded to floats.
fn moved(scene: &Scene, by: DVec3) -> Scene {
    let mut scene = scene.clone();
    step(&mut scene, by);
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Directional { .. } => {}
            LightKind::Spot { position, .. } | LightKind::Point { position } | LightKind::Virtual { position, .. } => {
                *position += by;
            }
        }
    }
    (scene.camera.position, scene.camera.target) = (scene.camera.position + by, scene.camera.target + by);
    scene
}
