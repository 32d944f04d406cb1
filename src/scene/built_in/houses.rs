//! The built-in scenes `houses`, `leaves` and `shafts`: 400 closed houses on hilly ground. Ground and houses are embedded data
//! (`data/README.md`); leaves are placed at random.

use crate::scene::built_in::embedded::{GROUND, HOUSES, sun, vectors};
use crate::scene::files::mesh_file::DEFAULT_ALBEDO;
use crate::scene::model::random::Random;
use crate::scene::{Camera, Light, LightKind, Mesh, Scene};
use glam::DVec3;

/// Number of vertices per side of the ground, and the distance between them along x and y.
const SIDE: u32 = 129;
const APART_WORLD: f32 = 1.5625;

/// Number of vertices of a house: the eight of its box, and both ends of its ridge.
const CORNERS: u32 = 10;

/// Triangles of a box with a pitched roof, counter-clockwise from outside.
const TRIANGLES: [[u32; 3]; 16] = [
    [3, 2, 1],
    [3, 1, 0],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
    [4, 5, 9],
    [4, 9, 8],
    [6, 7, 8],
    [6, 8, 9],
    [7, 4, 8],
    [5, 6, 9],
];

const TREES: u32 = 400;
const LEAVES_A_TREE: u32 = 150;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x1eaf, 3];

/// Builds the houses on their solid ground, under the sun.
pub(in crate::scene) fn houses() -> Scene {
    scene("houses", sun(DVec3::new(0.4, 0.35, -0.8)), [DVec3::new(150.0, -45.0, 60.0), DVec3::new(95.0, 70.0, 0.0)])
}

/// Builds the houses among 400 trees of 150 leaves. Each leaf is a single open triangle.
pub(in crate::scene) fn leaves() -> Scene {
    let mut scene = houses();
    let leaves = strewn(&scene.meshes[0]);
    scene.meshes.push(leaves);
    Scene { name: "leaves".into(), ..scene }
}

/// Builds the houses with a lamp among them.
pub(in crate::scene) fn shafts() -> Scene {
    scene(
        "shafts",
        Light {
            kind: LightKind::Point { position: DVec3::new(104.0, 40.0, 9.0) },
            radiance: [3.0, 2.2, 1.2],
            radius: f64::INFINITY,
        },
        [DVec3::new(135.0, -5.0, 30.0), DVec3::new(100.0, 48.0, 4.0)],
    )
}

fn scene(name: &str, light: Light, [position, target]: [DVec3; 2]) -> Scene {
    let corners = vectors(HOUSES);
    let count = corners.len() as u32 / CORNERS;
    let house = |i: u32| TRIANGLES.map(|triangle| triangle.map(|corner| CORNERS * i + corner));
    let houses = mesh("houses", corners, (0..count).flat_map(house).collect());
    Scene {
        name: name.into(),
        meshes: vec![ground(), houses],
        lights: vec![light],
        camera: Camera { position, target, up: DVec3::Z, fov_y_degrees: 45.0 },
        ..Scene::default()
    }
}

fn mesh(name: &str, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { name: name.into(), positions, triangles, albedo: DEFAULT_ALBEDO, solid: false, alpha: None }
}

fn ground() -> Mesh {
    let place = |i: u32| APART_WORLD * i as f32;
    let heights = bytemuck::pod_collect_to_vec::<u8, f32>(GROUND);
    let position = |(i, height): (u32, &f32)| [place(i / SIDE), place(i % SIDE), *height];
    let squares = (0..SIDE - 1).flat_map(|i| (0..SIDE - 1).map(move |j| SIDE * i + j));
    let halves = |a: u32| [[a, a + SIDE, a + SIDE + 1], [a, a + SIDE + 1, a + 1]];
    let ground = mesh("ground", (0..).zip(&heights).map(position).collect(), squares.flat_map(halves).collect());
    Mesh { solid: true, ..ground }
}

/// Builds the leaves of all trees, at random positions over the ground.
fn strewn(ground: &Mesh) -> Mesh {
    let mut random = Random::new(SEED);
    let reach = f64::from(APART_WORLD) * f64::from(SIDE - 1);
    let mut positions = Vec::new();
    for _ in 0..TREES {
        let at = [(); 2].map(|()| random.between(5.0, reach - 5.0));
        let [i, j] = at.map(|along| (along / f64::from(APART_WORLD)) as usize);
        let height = f64::from(ground.positions[SIDE as usize * i + j][2]) + random.between(2.5, 3.4);
        let middle = DVec3::new(at[0], at[1], height);
        let spread = random.between(0.75, 1.65);
        for _ in 0..LEAVES_A_TREE {
            let mut about = |size: f64| size * (random.in_ball() + random.in_ball());
            let leaf = middle + about(spread);
            let ends = [leaf, leaf + about(0.31), leaf + about(0.31)];
            positions.extend(ends.map(|end| end.as_vec3().to_array()));
        }
    }
    let leaf = |i: u32| [3 * i, 3 * i + 1, 3 * i + 2];
    mesh("leaves", positions, (0..TREES * LEAVES_A_TREE).map(leaf).collect())
}
