//! The built-in scene `splats`: a ground and an arch of flat splats, and a bush of needle-shaped splats. Their shapes are typical of
//! captured scenes.

use crate::scene::{Camera, Light, LightKind, Random, Scene, Splat};
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x3d65, 1];

/// The number of splats at which the sizes below apply; if there are more, each is smaller.
const USUAL: f64 = 6000.0;

/// The largest number of splats in the scene.
pub(in crate::scene) const MOST: u32 = 4_000_000;

/// Number of splats in every ten that belong to the ground and to the arch; the rest belong to the bush.
const GROUND: u32 = 4;
const ARCH: u32 = 4;

/// Half the ground's side, the arch's radius, and the radius of its tube, in world units.
const GROUND_WORLD: f64 = 3.0;
const ARCH_WORLD: f64 = 1.3;
const TUBE_WORLD: f64 = 0.32;

/// Builds `count` splats under one low light. Flat splats lie on surfaces and are a 20th as thick as they are wide. Needles are 16 times as
/// long as they are thick. The result is bit-identical on every call and machine.
pub(in crate::scene) fn splats(name: &str, count: u32) -> Scene {
    let mut random = Random::new(SEED);
    let fine = (USUAL / f64::from(count)).sqrt();
    let splats = (0..count)
        .map(|i| match i % 10 {
            place if place < GROUND => ground(&mut random, fine),
            place if place < GROUND + ARCH => arch(&mut random, fine),
            _ => bush(&mut random, fine),
        })
        .collect();
    Scene {
        name: name.into(),
        splats,
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.55, 0.35, -0.76).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(3.6, -6.2, 3.4),
            target: DVec3::new(0.1, 0.1, 0.45),
            up: DVec3::Z,
            fov_y_degrees: 38.0,
        },
        ..Scene::default()
    }
}

/// Builds a flat splat on a surface with the given normal, randomly rotated about the normal.
fn flat(random: &mut Random, position: DVec3, normal: DVec3, wide: f64, opacity: f64, color: [f64; 3]) -> Splat {
    let turn = DQuat::from_rotation_arc(DVec3::Z, normal) * DQuat::from_rotation_z(random.between(0.0, PI));
    let deviations = DVec3::new(wide, wide * random.between(0.5, 1.0), 0.05 * wide);
    splat(position, deviations, turn, opacity, color)
}

fn splat(position: DVec3, deviations: DVec3, turn: DQuat, opacity: f64, color: [f64; 3]) -> Splat {
    Splat {
        position: position.as_vec3().into(),
        deviations: deviations.as_vec3().into(),
        rotation: turn.normalize().as_quat().to_array(),
        opacity: opacity as f32,
        color: color.map(|c| c as f32),
    }
}

fn ground(random: &mut Random, fine: f64) -> Splat {
    let mut across = || random.between(-GROUND_WORLD, GROUND_WORLD);
    let position = DVec3::new(across(), across(), 0.0);
    let grey = random.between(0.55, 0.75);
    let opacity = random.between(0.5, 0.95);
    flat(random, position, DVec3::Z, 0.09 * fine, opacity, [grey, 0.95 * grey, 0.85 * grey])
}

fn arch(random: &mut Random, fine: f64) -> Splat {
    let (around, about) = (random.between(0.0, PI), random.between(0.0, 2.0 * PI));
    let out = DVec3::new(around.cos(), 0.0, around.sin());
    let normal = about.cos() * out + about.sin() * DVec3::Y;
    let position = ARCH_WORLD * out + TUBE_WORLD * normal;
    let shade = random.between(0.75, 1.0);
    let opacity = random.between(0.6, 0.99);
    flat(random, position, normal, 0.06 * fine, opacity, [0.80 * shade, 0.42 * shade, 0.30 * shade])
}

fn bush(random: &mut Random, fine: f64) -> Splat {
    let place = random.in_ball();
    let position = DVec3::new(-0.2, -1.6, 0.55) + 0.55 * place;
    let along = (place + 0.6 * random.in_ball() + 0.4 * DVec3::Z).normalize();
    let side = along.any_orthonormal_vector();
    let turn = DQuat::from_mat3(&DMat3::from_cols(along, side, along.cross(side)));
    let long = random.between(0.06, 0.12) * fine;
    let green = random.between(0.35, 0.75);
    let opacity = random.between(0.3, 0.9);
    splat(position, DVec3::new(long, long / 16.0, long / 16.0), turn, opacity, [0.5 * green, green, 0.3 * green])
}
