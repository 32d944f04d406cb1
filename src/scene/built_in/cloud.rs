//! The built-in scene `cloud`: a procedural cumulus in a sparse grid of densities like those of OpenVDB files.

use crate::scene::{Camera, Field, Light, LightKind, Mesh, Placed, Scene, Volume};
use crate::{Error, Result};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// The largest number of samples per side.
pub(in crate::scene) const MOST: u32 = 256;

/// Width of the cloud, in world units.
const WIDE: f64 = 3.2;

/// Extinction where the cloud is densest, in 1 / world unit.
const EXTINCTION: f64 = 9.0;

/// Centres and radii of the balls that shape the cloud, in units of half its width.
const BALLS: [([f64; 3], f64); 7] = [
    ([0.0, 0.0, -0.15], 0.42),
    ([0.38, 0.1, -0.28], 0.3),
    ([-0.42, -0.08, -0.26], 0.33),
    ([0.1, 0.3, -0.3], 0.28),
    ([-0.12, -0.32, -0.3], 0.27),
    ([0.12, -0.05, 0.22], 0.3),
    ([-0.2, 0.12, 0.12], 0.26),
];

/// Builds the cloud with `samples` samples per side, under one sun, above a ground. Its grid is rotated relative to the world's axes, as
/// grids in files may be.
pub(in crate::scene) fn cloud(name: &str, samples: u32) -> Result<Scene> {
    let wrong = |cause: String| Error::input(name, cause, "this is a bug of the built-in scene");
    let volume = volume(samples, 1).map_err(wrong)?;
    Ok(Scene {
        name: name.into(),
        volumes: vec![volume],
        meshes: vec![ground()],
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.5, 0.45, -0.74).normalize() },
            radiance: [1.0, 0.97, 0.9],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(2.6, -5.4, 2.0),
            target: DVec3::new(0.25, 0.3, 0.75),
            up: DVec3::Z,
            fov_y_degrees: 36.0,
        },
        ..Scene::default()
    })
}

/// Builds the cloud alone; `side` is as in [`Placed::side`].
fn volume(samples: u32, side: u32) -> std::result::Result<Volume, String> {
    let count = samples as i32;
    let places = (0..count).flat_map(|z| (0..count).flat_map(move |y| (0..count).map(move |x| [x, y, z])));
    let place = |at: i32| (f64::from(at) + 0.5) / f64::from(count) * 2.0 - 1.0;
    let field = Field::new(places.map(|sample| (sample, density(DVec3::from_array(sample.map(place))) as f32)))?;
    let turn = DQuat::from_rotation_z(0.35);
    let step = WIDE / f64::from(samples);
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis * step);
    let middle = 0.5 * (f64::from(samples) - 1.0);
    let origin = DVec3::new(0.0, 0.0, 1.15) - middle * (steps[0] + steps[1] + steps[2]);
    let placed = Placed { origin, steps, extinction: EXTINCTION, color: [0.95, 0.95, 0.95], side };
    Volume::new(Arc::new(field), placed)
}

/// Returns the density, 0 to 1, at a position in units of half the cloud's width: balls with a flat bottom, their border displaced and
/// frayed by noise.
fn density(place: DVec3) -> f64 {
    let noise = fractal(place * 3.1);
    let within = |&(middle, radius): &([f64; 3], f64)| radius - (place - DVec3::from(middle)).length();
    let inside = BALLS.iter().map(within).fold(f64::NEG_INFINITY, f64::max) + 0.22 * noise;
    let bottom = (place.z + 0.5 + 0.05 * noise) / 0.12;
    let worn = (inside / 0.16).clamp(0.0, 1.0) * bottom.clamp(0.0, 1.0);
    worn * (0.55 + 0.45 * fractal(place * 9.0 + 5.0)).clamp(0.0, 1.0)
}

/// Returns four octaves of value noise, about −1 to 1.
fn fractal(place: DVec3) -> f64 {
    (0..4).map(|octave| f64::from(1 << octave)).map(|by| noise(place * by) / by).sum::<f64>()
}

/// Returns value noise: values of −½ to ½ at integer positions, interpolated smoothly.
fn noise(place: DVec3) -> f64 {
    let (cell, at) = (place.floor(), place - place.floor());
    let at = at * at * (3.0 - 2.0 * at);
    let value = |corner: i32| hashed([0, 1, 2].map(|axis| cell[axis] as i32 + (corner >> axis & 1)));
    let weight = |corner: i32| {
        (0..3).map(|axis| if corner >> axis & 1 == 1 { at[axis] } else { 1.0 - at[axis] }).product::<f64>()
    };
    (0..8).map(|corner| value(corner) * weight(corner)).sum()
}

/// Returns a pseudo-random number from −½ to ½. Source: Jarzynski and Olano 2020, *Hash Functions for GPU Rendering*, the x of pcg3d.
fn hashed(place: [i32; 3]) -> f64 {
    let [mut x, mut y, mut z] = place.map(|at| (at as u32).wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    [x, y, z] = [x, y, z].map(|v| v ^ v >> 16);
    x = x.wrapping_add(y.wrapping_mul(z));
    f64::from(x) / f64::from(u32::MAX) - 0.5
}

fn ground() -> Mesh {
    let far = 6.0;
    Mesh {
        name: "ground".into(),
        positions: vec![[-far, -far, 0.0], [far, -far, 0.0], [far, far, 0.0], [-far, far, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.55, 0.58, 0.5],
        solid: true,
        alpha: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cloud must be sparse and bit-identical on every call, and grids of different resolutions must contain the same amount of smoke.
    #[test]
    fn a_cloud_of_any_resolution() {
        let mass = |samples| {
            let volume = volume(samples, 1).expect("a cloud");
            let step = WIDE / f64::from(samples);
            let cells = volume.cells().len();
            assert!(cells > 0 && cells < (samples as usize).pow(3) * 6 / 10, "{samples}: {cells}");
            volume.field().cubes(8).map(|(_, density)| density * (8.0 * step).powi(3)).sum::<f64>()
        };
        let [coarse, fine] = [mass(32), mass(48)];
        assert!((coarse / fine - 1.0).abs() < 0.03, "{coarse} {fine}");
        assert_eq!(cloud("cloud", 16).expect("a scene"), cloud("cloud", 16).expect("a scene"));
    }
}
