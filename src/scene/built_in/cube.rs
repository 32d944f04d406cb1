//! The built-in scene `big-8k`: large particles that fill a volume.

use crate::scene::{Camera, Light, LightKind, Particle, Scene};
use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;
use std::f64::consts::PI;

/// Number of particles in the cube.
const PARTICLES: u32 = 8_192;

/// Side of the cube, which extends from the origin to (8, 8, 8). A particle is one unit wide.
const SIDE_WORLD: f64 = 8.0;

/// Radius of a particle; its diameter is an eighth of the side.
const RADIUS_WORLD: f64 = SIDE_WORLD / 16.0;

/// Expected optical depth along an axis through the cube's centre. e⁻⁴ ≈ 2 % of the light passes through, so that nearly the whole range of
/// transmittances occurs inside the cube.
const OPTICAL_DEPTH: f64 = 4.0;

/// The largest number of lights in the scene.
pub(in crate::scene) const MOST_LIGHTS: u32 = 64;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [8_192, 1];

/// Builds 8,192 spheres of one size, uniformly distributed at random in the cube (Particle Shadow Mapping's test case, *8K large
/// particles*), under `count` directional lights. The first light is slightly off the vertical; the others shine down from all around. The
/// result is bit-identical on every call and machine.
pub(in crate::scene) fn big_8k(name: &str, count: u32) -> Scene {
    // The centres fill only a smaller cube, whose side and volume are used here.
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
    // Multiples of the golden angle, so that all directions are distinct for any count.
    let around = |i: u32| {
        let (turn, down) = (f64::from(i) * 2.399_963, 0.4 + 0.5 * f64::from(i % 7) / 7.0);
        DVec3::new(turn.cos(), turn.sin(), -down).normalize()
    };
    let first = DVec3::new(0.2, 0.12, -0.97).normalize();
    let directions = std::iter::once(first).chain((1..count).map(around));
    let radiance = [1.0 / count as f32; 3];
    let light = |direction| Light { kind: LightKind::Directional { direction }, radiance, radius: f64::INFINITY };
    Scene {
        name: name.into(),
        particles,
        lights: directions.map(light).collect(),
        camera: Camera {
            position: DVec3::new(17.0, -11.0, 11.0),
            target: DVec3::splat(SIDE_WORLD / 2.0),
            up: DVec3::Z,
            fov_y_degrees: 38.0,
        },
        ..Scene::default()
    }
}
