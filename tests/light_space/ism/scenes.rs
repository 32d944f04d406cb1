//! Small scenes under virtual point lights.

use crate::support::scenes::{self, Random, cuboid};
use glam::DVec3;
use gobo::scene::{Light, LightKind, Mesh, Scene};

/// Returns a virtual light.
pub fn light(position: DVec3, normal: DVec3) -> Light {
    let kind = LightKind::Virtual { position, normal: normal.normalize(), nearest: 0.1 };
    Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }
}

/// Returns a scene of these meshes under these lights.
pub fn under(name: &str, meshes: Vec<Mesh>, lights: Vec<Light>) -> Scene {
    let mut scene = scenes::directional(name, [0.0, 0.0, -1.0], Vec::new());
    (scene.meshes, scene.lights) = (meshes, lights);
    scene
}

/// Returns lights on all sides of the origin, some exactly along an axis.
pub fn lights(count: usize) -> Vec<Light> {
    let mut random = Random::new(7);
    let axes = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y];
    let mut one = |i: usize| {
        let at = DVec3::from(random.point(-2.0, 2.0).map(f64::from));
        let towards = DVec3::from(random.point(-1.0, 1.0).map(f64::from));
        light(at, axes.get(i).copied().unwrap_or(towards - 0.3 * at))
    };
    (0..count).map(&mut one).collect()
}

/// Triangles of all sizes: open and closed, level, slivers, degenerate, and one as wide as the whole scene.
pub fn soup() -> Scene {
    let mut random = Random::new(3);
    let mut positions = Vec::new();
    for i in 0..300 {
        let size = [0.01, 0.1, 0.5, 2.0][i % 4];
        let at = random.point(-2.0, 2.0);
        let mut corner = || {
            let by = random.point(-size, size);
            [0, 1, 2].map(|axis| at[axis] + by[axis])
        };
        let (a, b, mut c) = (corner(), corner(), corner());
        if i % 17 == 0 {
            c = b;
        }
        positions.extend([a, b, c]);
    }
    positions.extend([[-4.0, -4.0, -2.5], [4.0, -4.0, -2.5], [0.0, 5.0, -2.5]]);
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let soup = Mesh { name: "soup".into(), positions, triangles, albedo: [0.5; 3], solid: false, alpha: None };
    let blocks = [([-1.0, -1.0, -1.0], [0.5, 0.0, 0.25]), ([0.2, 0.2, 0.2], [1.5, 1.0, 0.3])];
    let meshes = blocks.map(|(low, high)| cuboid(low, high)).into_iter().chain([soup]).collect();
    under("soup", meshes, lights(24))
}

/// A closed room of slabs, 4 units wide, with a table in it and lights on its floor and walls.
pub fn room() -> Scene {
    let (h, t) = (2.0, 0.3);
    let slabs = [0, 1, 2].into_iter().flat_map(|axis| {
        [-1.0, 1.0].map(|side: f32| {
            let (mut low, mut high) = ([-h - t; 3], [h + t; 3]);
            (low[axis], high[axis]) = if side < 0.0 { (-h - t, -h) } else { (h, h + t) };
            cuboid(low, high)
        })
    });
    let things = [cuboid([-0.8, -0.6, -0.6], [0.8, 0.6, -0.4]), cuboid([-0.2, -0.2, -1.999], [0.2, 0.2, -0.6])];
    let meshes: Vec<_> = slabs.chain(things).collect();
    let mut random = Random::new(5);
    let mut one = |i: usize| {
        let [u, v] = [random.between(-1.9, 1.9), random.between(-1.9, 1.9)].map(f64::from);
        match i % 3 {
            0 => light(DVec3::new(u, v, -1.99), DVec3::Z),
            1 => light(DVec3::new(-1.99, u, v), DVec3::X),
            _ => light(DVec3::new(u, 1.99, v), DVec3::NEG_Y),
        }
    };
    let lights = (0..30).map(&mut one).collect();
    under("room", meshes, lights)
}
