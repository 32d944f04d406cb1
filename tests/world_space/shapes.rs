//! Meshes with the cases in which voxels fail.

use crate::support::scenes::{Random, cuboid, directional};
use gobo::scene::{Mesh, Scene};

/// A grid with relief, never seen from below.
fn ground(solid: bool) -> Mesh {
    let side = 9u32;
    let at = |i: u32| {
        let (x, y) = ((i % side) as f32 / 4.0 - 1.0, (i / side) as f32 / 4.0 - 1.0);
        [x, y, 0.07 * (3.0 * x).sin() * (2.0 * y).cos()]
    };
    let quad = |i: u32| [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]];
    let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    Mesh {
        name: "ground".into(),
        positions: (0..side * side).map(at).collect(),
        triangles: cells.flat_map(quad).collect(),
        albedo: [0.4; 3],
        solid,
        alpha: None,
    }
}

fn scene(name: &str, direction: [f64; 3], meshes: Vec<Mesh>) -> Scene {
    Scene { meshes, ..directional(name, direction, Vec::new()) }
}

/// Direction of a light oblique to all axes.
const SLANTED: [f64; 3] = [0.4, 0.35, -0.8];

/// Boxes that intersect a solid ground and each other.
pub fn houses() -> Scene {
    let boxes = [
        cuboid([-0.6, -0.5, -0.2], [-0.2, 0.1, 0.4]),
        cuboid([-0.3, -0.3, -0.2], [0.1, 0.0, 0.25]),
        cuboid([0.3, 0.2, -0.2], [0.5, 0.6, 0.5]),
    ];
    scene("houses", SLANTED, std::iter::once(ground(true)).chain(boxes).collect())
}

/// Thin open triangles in random places, some of them slivers.
pub fn soup() -> Scene {
    let mut random = Random::new(8);
    let mut meshes = vec![ground(false)];
    for i in 0..60 {
        let at = random.point(-0.8, 0.8);
        let reach = if i % 7 == 0 { 0.9 } else { 0.15 };
        let corner = |random: &mut Random| {
            let by = random.point(-reach, reach);
            [0, 1, 2].map(|axis| at[axis] + by[axis])
        };
        let positions = vec![at, corner(&mut random), corner(&mut random)];
        let name = "triangle".into();
        meshes.push(Mesh { name, positions, triangles: vec![[0, 1, 2]], albedo: [0.5; 3], solid: false, alpha: None });
    }
    scene("soup", SLANTED, meshes)
}

/// Corners and edges on column centres, light along an axis, boxes that touch face to face, one of them inside out.
fn aligned() -> Scene {
    let mut inward = cuboid([-1.0, 0.0, 0.0], [-0.5, 0.5, 0.5]);
    inward.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let touching = [cuboid([0.0, 0.0, 0.0], [0.5, 0.5, 0.5]), cuboid([0.0, 0.0, -0.5], [0.5, 0.5, 0.0])];
    scene("aligned", [0.0, 0.0, -1.0], touching.into_iter().chain([inward]).collect())
}

/// One triangle as large as the world, and many smaller than a voxel.
pub fn extremes() -> Scene {
    let mut meshes = vec![cuboid([-4.0, -4.0, -0.3], [4.0, 4.0, -0.2])];
    let mut random = Random::new(4);
    for _ in 0..300 {
        let at = random.point(-3.0, 3.0);
        let positions = vec![at, [at[0] + 0.01, at[1], at[2] + 0.01], [at[0], at[1] + 0.02, at[2]]];
        let name = "mote".into();
        meshes.push(Mesh { name, positions, triangles: vec![[0, 1, 2]], albedo: [0.5; 3], solid: false, alpha: None });
    }
    scene("extremes", [0.3, -0.2, -0.4], meshes)
}

/// A scene without casters.
fn nothing() -> Scene {
    scene("nothing", SLANTED, Vec::new())
}

/// One plate across the light: the root node alone describes all of it.
fn plate() -> Scene {
    scene("plate", [0.0, 0.0, -1.0], vec![cuboid([-1.0, -1.0, -0.01], [1.0, 1.0, 0.01])])
}

/// A sliver and a closed box from corner to corner, a quarter as thick as a voxel at 64 per side, with or without a plane below them.
pub fn wires(plane: bool) -> Scene {
    let thick = 0.008;
    let sliver = [[-0.8, -0.7, 0.1], [0.7, 0.8, 0.5], [0.7, 0.8 - thick, 0.5 + thick], [-0.8, -0.7 - thick, 0.1]];
    let mut wire = cuboid([0.0; 3], [1.0, thick, thick]);
    wire.positions.iter_mut().for_each(|p| *p = [1.5 * p[0] - 0.7, p[1] + 0.3 - 0.9 * p[0], p[2] + 0.2 + 0.3 * p[0]]);
    let quad = |positions: [[f32; 3]; 4]| Mesh {
        name: "quad".into(),
        positions: positions.into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    };
    let mut meshes = vec![quad(sliver), wire];
    if plane {
        meshes.push(quad([[-1.0, -1.0, -0.9], [1.0, -1.0, -0.9], [1.0, 1.0, -0.9], [-1.0, 1.0, -0.9]]));
    }
    scene("wires", SLANTED, meshes)
}

pub fn all() -> Vec<Scene> {
    vec![houses(), soup(), aligned(), extremes(), plate(), nothing(), wires(true)]
}

/// Returns points in and around the meshes' bounds.
pub fn about(scene: &Scene, count: usize) -> Vec<[f32; 3]> {
    let mut random = Random::new(5);
    let all = scene.meshes.iter().flat_map(|m| &m.positions).flatten();
    let most = 1.3 * all.fold(0.5f32, |most, v| most.max(v.abs()));
    (0..count).map(|_| random.point(-most, most)).collect()
}

/// Scenes for tests of visible surfaces.
pub fn seen() -> Vec<Scene> {
    vec![houses(), soup(), touching()]
}

/// Boxes on a ground that touch face to face, one of them inside out.
fn touching() -> Scene {
    let mut inward = cuboid([-0.7, 0.0, 0.0], [-0.3, 0.5, 0.3]);
    inward.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let slab = cuboid([-1.0, -1.0, -0.2], [1.0, 1.0, 0.0]);
    let touching = [cuboid([0.0, 0.0, 0.0], [0.3, 0.3, 0.3]), cuboid([0.0, 0.0, 0.3], [0.3, 0.3, 0.5])];
    scene("touching", SLANTED, [slab, inward].into_iter().chain(touching).collect())
}

/// A square of two triangles with side 2, centred on the origin, at z = 0; or a slab with that top.
pub fn flat(direction: [f64; 3], closed: bool) -> Scene {
    let plane = Mesh {
        name: "plane".into(),
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    };
    let mesh = if closed { cuboid([-1.0, -1.0, -0.1], [1.0, 1.0, 0.0]) } else { plane };
    scene("flat", direction, vec![mesh])
}

/// A square of many triangles with side 2, centred on the origin, at z = 0.
pub fn tessellated(direction: [f64; 3]) -> Scene {
    let mut plane = ground(false);
    plane.positions.iter_mut().for_each(|p| p[2] = 0.0);
    scene("tessellated", direction, vec![plane])
}

/// A wall at x = 0 on a plane, `voxels` high at 256 per side, under light along x at 45 degrees.
pub fn wall(voxels: f32) -> Scene {
    let mut scene = flat([1.0, 0.0, -1.0], false);
    // At 45 degrees the plane's projection is narrower than it is deep, so the cube is as wide as the plane.
    let height = voxels * 2.0 / 256.0;
    scene.meshes.push(Mesh {
        name: "wall".into(),
        positions: vec![[0.0, -0.9, 0.0], [0.0, 0.9, 0.0], [0.0, 0.9, height], [0.0, -0.9, height]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    });
    scene
}
