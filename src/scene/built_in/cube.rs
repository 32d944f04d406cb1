//! The built-in scene `big-8k`: large particles that fill a volume.

use crate::scene::{Camera, Light, LightKind, Motion, Particle, Scene};
use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;
use std::f64::consts::PI;

/// Particles in the cube.
const PARTICLES: u32 = 8_192;

/// The cube reaches from the origin to (8, 8, 8): a particle is one unit wide.
const SIDE_WORLD: f64 = 8.0;

/// An eighth of the side across.
const RADIUS_WORLD: f64 = SIDE_WORLD / 16.0;

/// Expected along an axis through the cube's middle: e⁻⁴ ≈ 2 % of the light comes through, so that the whole range of
/// transmittances lies inside the cube.
const OPTICAL_DEPTH: f64 = 4.0;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [8_192, 1];

/// 8,192 spheres of one size, their diameter an eighth of the cube's side, uniformly at random wholly inside the cube
/// (Particle Shadow Mapping's test case, *8K large particles*), a directional light slightly off the vertical. The same
/// bytes on every call and machine.
pub(in crate::scene) fn big_8k() -> Scene {
    // The centres fill a smaller cube, so the length and the volume that they fill are the smaller cube's.
    let centre_side = SIDE_WORLD - 2.0 * RADIUS_WORLD;
    let sphere_volume = 4.0 / 3.0 * PI * RADIUS_WORLD.powi(3);
    let spheres_along_the_middle = f64::from(PARTICLES) * sphere_volume / (centre_side * centre_side);
    let extinction = (OPTICAL_DEPTH / spheres_along_the_middle) as f32;

    let mut random = Pcg32::new(SEED[0], SEED[1]);
    let mut coordinate = || (RADIUS_WORLD + centre_side * f64::from(random.next_u32()) / f64::from(u32::MAX)) as f32;
    let particles = (0..PARTICLES)
        .map(|_| Particle {
            position: [coordinate(), coordinate(), coordinate()],
            radius: RADIUS_WORLD as f32,
            extinction,
        })
        .collect();
    Scene {
        name: "big-8k".into(),
        particles,
        strands: Vec::new(),
        meshes: Vec::new(),
        motion: Motion::Still,
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.2, 0.12, -0.97).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(17.0, -11.0, 11.0),
            target: DVec3::splat(SIDE_WORLD / 2.0),
            up: DVec3::Z,
            fov_y_degrees: 38.0,
        },
    }
}
