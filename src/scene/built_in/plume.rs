//! The built-in scene `plume-1m`: one plume of a million small particles.

use crate::Result;
use crate::scene::built_in::emitters::{Emitter, smoke};
use crate::scene::{Camera, Light, LightKind, Particle, Scene};
use glam::{DVec3, Vec3};
use rand::Rng;
use rand_pcg::Pcg32;

/// Number of particles per puff. Over all puffs alive at once, that makes 1,000,000.
const PARTICLES: usize = 64;

/// Radius of a particle, relative to its puff's.
const SIZE: f32 = 0.33;

/// Maximum distance of a particle from its puff's centre along each axis, relative to the puff's radius.
const APART: f32 = 1.0;

/// Extinction of a particle, relative to its puff's: a ray through the plume loses most of its light.
const THIN: f32 = 0.1;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x5eed_1000, 44];

/// The scene's time: a puff's lifetime, so that all puffs exist.
const TIME_S: f64 = 18.0;

const PUFFS: Emitter = Emitter {
    seed: [0x5eed_0004, 44],
    capacity: 15_625,
    lifetime_s: TIME_S,
    position: DVec3::new(0.0, 0.0, 0.25),
    nozzle_radius_world: 2.4,
    velocity: DVec3::new(0.0, 0.0, 0.5),
    velocity_spread: 0.2,
    rise: [0.4, 0.3],
    drag: 1.5,
    swirl: 0.2,
    drift: 0.05,
    radius_world: [0.4, 0.5],
    optical_depth: 0.09,
};

/// Builds a million particles under a slanted directional light, and nothing else. Neighbours in the list are similar in age, but not in
/// position. The result is bit-identical on every call and machine.
///
/// # Errors
/// None: the time is in range.
pub(in crate::scene) fn plume_1m() -> Result<Scene> {
    let puffs = smoke("plume-1m", &[PUFFS], TIME_S)?;
    let mut random = Pcg32::new(SEED[0], SEED[1]);
    let mut aside = || 2.0 * APART * (random.next_u32() as f32 / u32::MAX as f32) - APART;
    let mut particles = Vec::with_capacity(PARTICLES * puffs.len());
    for _ in 0..PARTICLES {
        particles.extend(puffs.iter().map(|puff| {
            let radius = SIZE * puff.radius;
            let at = Vec3::from(puff.position) + puff.radius * Vec3::new(aside(), aside(), aside());
            // No particle sinks below the ground from which the plume rises.
            let position = at.with_z(at.z.max(radius)).to_array();
            Particle { position, radius, extinction: THIN * puff.extinction }
        }));
    }
    Ok(Scene {
        name: "plume-1m".into(),
        particles,
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.5, 0.3, -0.81).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(7.0, -11.0, 5.5),
            target: DVec3::new(0.0, 0.0, 3.0),
            up: DVec3::Z,
            fov_y_degrees: 38.0,
        },
        ..Scene::default()
    })
}
