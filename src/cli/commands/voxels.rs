//! `gobo voxels`: the voxels that meshes occupy, or the nodes of a shadow's tree, as boxes.

use crate::animate::AnimatedScene;
use crate::cli::commands::render;
use crate::cli::{load, test_reduction};
use crate::query::Query;
use crate::reference::twin::alpha;
use crate::reference::twin::grid::{Bits, Place};
use crate::scene::{Light, LightKind, Mesh, Scene};
use crate::technique::{Opened, Technique, Voxelized, voxelized};
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use glam::{DVec3, Vec3};
use std::process::ExitCode;

/// Alternating colors of a grid's voxels, so that neighbours can be told apart.
const VOXELS: [[f32; 3]; 2] = [[0.62, 0.58, 0.52], [0.46, 0.44, 0.42]];

/// Colors of nodes by size, from one voxel per side up: Okabe and Ito 2008.
const NODES: [[f32; 3]; 6] = [
    [0.80, 0.11, 0.0],
    [0.80, 0.35, 0.0],
    [0.87, 0.78, 0.05],
    [0.0, 0.34, 0.17],
    [0.09, 0.46, 0.81],
    [0.0, 0.17, 0.45],
];

#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    pub(in crate::cli) picture: render::Arguments,
    /// Voxels per side: 64, 128, 192 or 256; a power of two for a tree
    #[arg(long, default_value_t = 64, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=256))]
    size: u32,
    /// Instead of voxel-grid's voxels, draw the nodes of voxelized's tree that lie in shadow, colored by size: red is one voxel
    #[arg(long)]
    tree: bool,
    /// With --tree: the light, from 0, which must be directional
    #[arg(long, default_value_t = 0, value_name = "N")]
    light: usize,
}

impl Arguments {
    /// With `GOBO_TEST_LITTLE`, returns a smaller version of the command.
    pub fn little(mut self) -> Self {
        if test_reduction::is_asked() {
            self.size = 64;
        }
        Self { picture: self.picture.little(), ..self }
    }
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let AnimatedScene { scene, animation, notes } = load(arguments.picture.scene(), arguments.picture.load())?;
    if !scene.has_triangles() {
        return Err(Error::input(scene.name, "there is no mesh in it", "name a scene of meshes, such as town"));
    }
    let meshes = if arguments.tree { tree(arguments, &scene)? } else { grid(&scene, arguments.size)? };
    let shown = Scene { meshes, particles: vec![], strands: vec![], splats: vec![], ..scene };
    render::run_scene(&arguments.picture, AnimatedScene { scene: shown, animation, notes })
}

/// Adds a box, given by its corner and its axes, to a mesh. `sides` selects the sides to add, in this order: low x, high x, low y, high y,
/// low z, high z.
fn put(mesh: &mut Mesh, corner: DVec3, axes: [DVec3; 3], sides: [bool; 6]) {
    for (side, _) in sides.iter().enumerate().filter(|(_, is)| **is) {
        let axis = side / 2;
        let (across, along) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        let begin = corner + if side % 2 == 1 { axes[axis] } else { DVec3::ZERO };
        let first = mesh.positions.len() as u32;
        let corners = [begin, begin + across, begin + across + along, begin + along];
        mesh.positions.extend(corners.map(|p| p.as_vec3().to_array()));
        // Counter-clockwise from outside if the axes are right-handed.
        let order = if side % 2 == 1 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
        mesh.triangles.extend(order.map(|t| t.map(|i| first + i)));
    }
}

fn empty(name: String, albedo: [f32; 3]) -> Mesh {
    Mesh { name, positions: vec![], triangles: vec![], albedo, solid: false, alpha: None }
}

/// Returns the occupied voxels of a grid around all meshes, as their sides that face empty space.
fn grid(scene: &Scene, size: u32) -> Result<Vec<Mesh>> {
    // A grid has three levels of bits, each with a quarter of the side of the level below.
    if !size.is_multiple_of(64) {
        return Err(Error::usage(format!("--size {size}"), "a grid has a multiple of 64", "choose 64, 128 or 192"));
    }
    let triangles: Vec<_> = scene.meshes.iter().flat_map(alpha::triangles).collect();
    let place = Place::about(triangles.iter().flat_map(|(corners, _)| *corners), size);
    let among: Vec<_> = triangles.iter().map(|(corners, _)| corners.map(|corner| place.voxels(corner))).collect();
    let blocks = |number: usize, voxel: [u32; 3]| {
        let low = Vec3::from(voxel.map(|v| v as f32));
        triangles[number].1.as_ref().is_none_or(|alpha| alpha.covers(among[number].map(Vec3::from), low, 1.0))
    };
    let bits = Bits::voxelize_where(among.iter().copied(), size, blocks);
    let mut meshes = [0, 1].map(|i| empty(format!("voxels {i}"), VOXELS[i]));
    let side = f64::from(place.voxel);
    let axes = [DVec3::X * side, DVec3::Y * side, DVec3::Z * side];
    let origin = DVec3::from(place.origin.map(f64::from));
    for number in 0..size.pow(3) {
        let voxel = [number % size, number / size % size, number / size.pow(2)];
        if !bits.has(0, voxel) {
            continue;
        }
        let free = |side: usize| {
            let mut beside = voxel;
            let moved = if side % 2 == 1 { voxel[side / 2] + 1 } else { voxel[side / 2].wrapping_sub(1) };
            beside[side / 2] = moved;
            moved >= size || !bits.has(0, beside)
        };
        let at = origin + DVec3::from(voxel.map(f64::from)) * side;
        let parity = (voxel.iter().sum::<u32>() % 2) as usize;
        put(&mut meshes[parity], at, axes, std::array::from_fn(free));
    }
    Ok(meshes.into_iter().filter(|mesh| !mesh.triangles.is_empty()).collect())
}

/// Returns the scene's meshes, and the nodes of a tree that lie entirely in shadow. Each node is drawn at the size at which it is stored:
/// eight nodes of one kind become one node of the next level. Whether a voxel is in shadow is looked up in the tree itself, at its centre.
fn tree(arguments: &Arguments, scene: &Scene) -> Result<Vec<Mesh>> {
    let is_directional = |light: &Light| matches!(light.kind, LightKind::Directional { .. });
    let name = format!("--light {}", arguments.light);
    let Some(light) = scene.lights.get(arguments.light) else {
        return Err(Error::input(name, format!("the scene has {} lights, from 0", scene.lights.len()), "choose one"));
    };
    if !is_directional(light) {
        return Err(Error::input(
            name,
            "it is not directional",
            "choose another, or a scene with a sun, such as houses",
        ));
    }
    let size = arguments.size;
    if !(64..=256).contains(&size) || !size.is_power_of_two() {
        return Err(Error::usage(format!("--size {size}"), "no size of a tree", "choose 64, 128 or 256"));
    }
    let context = arguments.picture.device.open()?;
    let world = World::new(&context, scene)?;
    let settings = voxelized::Settings { size, filter: 1, ..Default::default() };
    let mut opened = Opened::new(&context, Box::new(Voxelized::new(&context, &world, &settings)?), true);
    opened.build(&world)?;
    let trees = opened.technique.trees()?;
    let data = trees[arguments.light];
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    // A voxel's sides in world units: the axes are in voxels per world unit.
    let axes = [data.right, data.up, data.forward].map(|axis| wide(axis) / wide(axis).length_squared());
    let at = |voxel: [f64; 3]| wide(data.origin) + axes[0] * voxel[0] + axes[1] * voxel[1] + axes[2] * voxel[2];
    let voxel = |number: u32, size: u32| [number % size, number / size % size, number / size.pow(2)];
    let middles: Vec<[f32; 3]> = (0..size.pow(3))
        .map(|number| at(voxel(number, size).map(|i| f64::from(i) + 0.5)).as_vec3().to_array())
        .collect();
    let query = Query::new(&context, arguments.light, &middles)?;
    let answers = query.ask(&opened.technique.answer())?;
    let mut meshes = scene.meshes.clone();
    // The state of each node of a level: all dark, all lit, or `None` if mixed.
    let mut level: Vec<Option<bool>> = answers.iter().map(|visibility| Some(*visibility < 0.5)).collect();
    let (mut side, mut number) = (size, 0);
    while side > 1 {
        let half = side / 2;
        let above: Vec<Option<bool>> = (0..half.pow(3))
            .map(|n| {
                let first = voxel(n, half).map(|i| 2 * i);
                let child = |c: u32| {
                    let [x, y, z] = [first[0] + (c & 1), first[1] + (c >> 1 & 1), first[2] + (c >> 2)];
                    level[((z * side + y) * side + x) as usize]
                };
                (1..8).all(|c| child(c) == child(0)).then(|| child(0)).flatten()
            })
            .collect();
        let mut mesh = empty(format!("nodes {number}"), NODES[number.min(NODES.len() - 1)]);
        for (n, _) in (0..).zip(&level).filter(|(_, state)| **state == Some(true)) {
            let place = voxel(n, side);
            let [x, y, z] = place.map(|i| i / 2);
            if above[((z * half + y) * half + x) as usize].is_none() {
                let scale = f64::from(size / side);
                let corner = at(place.map(|i| f64::from(i) * scale));
                put(&mut mesh, corner, axes.map(|axis| axis * scale), [true; 6]);
            }
        }
        if !mesh.triangles.is_empty() {
            meshes.push(mesh);
        }
        (level, side, number) = (above, half, number + 1);
    }
    Ok(meshes)
}
