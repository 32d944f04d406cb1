//! The built-in scene `sparse`: a few puffs far apart, so that most of the light's map is empty.

use crate::scene::{Camera, Light, LightKind, Particle, Scene};
use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;

/// Number of puffs per side of the square grid that they form; they cover about a tenth of its area.
const PUFFS: i32 = 4;

/// Number of particles per puff.
const PARTICLES: usize = 24;

/// Distance between neighbouring puffs.
const APART_WORLD: f64 = 2.0;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x5ba5e, 1];

/// Builds 16 puffs of 24 particles under a directional light, whose casters cover about a tenth of the tiles of its map. The result is
/// bit-identical on every call and machine.
pub(in crate::scene) fn sparse() -> Scene {
    let mut random = Pcg32::new(SEED[0], SEED[1]);
    let mut between = |low: f64, high: f64| low + (high - low) * f64::from(random.next_u32()) / f64::from(u32::MAX);
    let mut particles = Vec::new();
    for cell in 0..PUFFS * PUFFS {
        let corner = DVec3::new(f64::from(cell % PUFFS), f64::from(cell / PUFFS), 0.0) * APART_WORLD;
        let puff = corner + DVec3::new(0.0, 0.0, between(0.5, 1.5));
        for _ in 0..PARTICLES {
            let position = puff + DVec3::new(between(-0.2, 0.2), between(-0.2, 0.2), between(-0.2, 0.2));
            let radius = between(0.04, 0.08);
            let extinction = (between(0.1, 0.5) / (2.0 * radius)) as f32;
            particles.push(Particle { position: position.as_vec3().into(), radius: radius as f32, extinction });
        }
    }
    let middle = DVec3::new(1.0, 1.0, 0.0) * (f64::from(PUFFS - 1) * APART_WORLD / 2.0);
    Scene {
        name: "sparse".into(),
        particles,
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.1, 0.05, -1.0).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: middle + DVec3::new(3.0, -9.0, 6.0),
            target: middle,
            up: DVec3::Z,
            fov_y_degrees: 40.0,
        },
        ..Scene::default()
    }
}
