//! The built-in scene `failures`: five rows, each showing a known failure of techniques, in front of a wall. The light comes from the left
//! and grazes the wall, so that each row's shadow on it shows transmittance along the ray. Smoke continues behind the wall; with `skip=off`
//! techniques store that part too.
//!
//! Only operations with results fixed by IEEE 754 are used, so the bytes are the same on every machine.

use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Scene, Strand};
use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;

/// Distance between the bottoms of neighbouring rows, and height of a row.
const ROW_WORLD: [f64; 2] = [0.85, 0.6];

/// Bottom of the lowest row.
const BOTTOM_WORLD: f64 = 0.35;

/// `WALL_WORLD`: y of the wall. `DEEP_WORLD`: y at which smoke and hair end. That is behind the wall, so that a light ray meets casters
/// both before and behind the point where it hits the wall.
const WALL_WORLD: f64 = 2.2;
const DEEP_WORLD: f64 = 4.8;

/// A sphere's radius divided by the distance to the next. With this overlap, the spheres form an even medium.
const OVERLAP: f64 = 1.2;

/// A sphere's volume divided by the cube of its radius.
const BALL: f64 = 4.0 / 3.0 * std::f64::consts::PI;

/// Hairs of the lowest row: their number, half the width of each, and opacity.
const HAIRS: usize = 1300;
const HAIR_RADIUS_WORLD: f32 = 0.008;
const HAIR_OPACITY: f32 = 0.3;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0xfa11, 1];

struct Random(Pcg32);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }
}

/// Returns z of the bottom and top of row `from_below`, counted from the lowest.
fn row(from_below: u32) -> [f64; 2] {
    let low = BOTTOM_WORLD + f64::from(from_below) * ROW_WORLD[0];
    [low, low + ROW_WORLD[1]]
}

/// Builds five rows under one directional light. From the top: a slab of even smoke; two walls of smoke with a gap between them; a thin
/// sheet; a dense wall in fog; fine hair. The result is bit-identical on every call and machine.
pub(in crate::scene) fn failures() -> Scene {
    let mut random = Random(Pcg32::new(SEED[0], SEED[1]));
    // Row; start and length along x; distance between spheres; optical depth along x.
    let particles = [
        (4, [2.0, 3.0], 0.12, 3.0),
        (3, [0.8, 0.4], 0.1, 0.7),
        (3, [5.0, 0.4], 0.1, 0.7),
        (2, [3.37, 0.06], 0.06, 0.9),
        (1, [0.2, 6.6], 0.24, 0.9),
        (1, [3.8, 0.1], 0.07, 0.8),
    ]
    .into_iter()
    .flat_map(|(from_below, along, apart, optical_depth)| {
        smoke(&mut random, row(from_below), along, apart, optical_depth)
    })
    .collect();
    let mut hair = || {
        let [x, y] = [random.between(0.5, 6.5), random.between(0.0, DEEP_WORLD)];
        let [start, end] = row(0).map(|z| [x as f32, y as f32, z as f32]);
        Strand { start, radius: HAIR_RADIUS_WORLD, end, opacity: HAIR_OPACITY }
    };
    Scene {
        name: "failures".into(),
        particles,
        strands: (0..HAIRS).map(|_| hair()).collect(),
        meshes: vec![wall()],
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.94, 0.342, 0.0).normalize() },
            radiance: [1.3; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(3.5, -9.5, 2.35),
            target: DVec3::new(3.5, WALL_WORLD, 2.35),
            up: DVec3::Z,
            fov_y_degrees: 25.0,
        },
        ..Scene::default()
    }
}

/// Fills a row with spheres, from x = `along[0]` over a length of `along[1]`. Each is jittered within its grid cell.
fn smoke(random: &mut Random, [low, high]: [f64; 2], along: [f64; 2], apart: f64, optical_depth: f64) -> Vec<Particle> {
    let (corner, sides) = (DVec3::new(along[0], 0.0, low), DVec3::new(along[1], DEEP_WORLD, high - low));
    let [nx, ny, nz] = (sides / apart).round().max(DVec3::ONE).to_array().map(|count| count as u32);
    let cell = sides / DVec3::new(f64::from(nx), f64::from(ny), f64::from(nz));
    let radius = OVERLAP * apart;
    let volume = BALL * radius * radius * radius;
    // Extinction is averaged over a cell of the grid: each cell contains one sphere's volume of smoke.
    let extinction = optical_depth / along[1] * (cell.x * cell.y * cell.z) / volume;
    let mut particles = Vec::new();
    for (i, j, k) in (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k)))) {
        // If the grid is only one sphere thick, spheres stay aligned.
        let moved = [nx, ny, nz].map(|count| if count > 1 { random.between(0.2, 0.8) } else { 0.5 });
        let place = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + DVec3::from(moved);
        let position = (corner + cell * place).as_vec3().into();
        particles.push(Particle { position, radius: radius as f32, extinction: extinction as f32 });
    }
    particles
}

/// Builds an open mesh, slightly wider and higher than the rows.
fn wall() -> Mesh {
    let corner = |x: f32, z: f32| [x, WALL_WORLD as f32, z];
    Mesh {
        name: "wall".into(),
        positions: vec![corner(-0.3, 0.0), corner(7.3, 0.0), corner(7.3, 4.7), corner(-0.3, 4.7)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.8; 3],
        solid: false,
        alpha: None,
    }
}
