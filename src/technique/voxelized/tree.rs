//! A tree of a light as look-ups read it: where it stands, and where its nodes are.

use super::buffers::Shape;
use super::cube::Cubes;
use crate::scene::{Projection, View};
use bytemuck::{Pod, Zeroable};

/// The most levels of a tree. The lowest are leaves, the next are bricks of 8 voxels per side, and the highest are nodes of 65,536 voxels
/// per side. Twin: Tree in glsl/technique/voxelized/tree.glsl.
pub const MAX_LEVELS: usize = 15;

/// A tree of a light. Twin: Tree in glsl/technique/voxelized/tree.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TreeData {
    /// The corner of the cube, or the position of a light that has one; world units.
    pub origin: [f32; 3],
    /// Voxels per side.
    pub size: u32,
    /// Voxels per world unit along the cube's x. For a light with a position, the dot product with a point's offset from the light is a
    /// column times a depth. The column is counted from the middle, and the depth is in voxels.
    pub right: [f32; 3],
    /// The root's level plus one.
    pub levels: u32,
    /// As `right`, along the cube's y.
    pub up: [f32; 3],
    /// 1: all is lit; 2: all is shadowed; 3: there are nodes.
    pub root: u32,
    /// Voxels per world unit along the cube's z, the way light travels.
    pub forward: [f32; 3],
    /// The root's node, as pointers name nodes.
    pub root_at: u32,
    /// Where the words begin of the cells that look-ups start from, in place of the first levels.
    pub shortcuts: u32,
    /// Where each level's nodes begin, words.
    pub at: [u32; MAX_LEVELS],
    /// Bits per pointer, for the nodes of each level.
    pub pointer_bits: [u32; MAX_LEVELS],
    /// 1 where the light has a position.
    pub perspective: u32,
    /// In the tree with number `i`: the first tree of the light with number `i`.
    pub first: u32,
    /// How many trees that light has; 0 where there is no such light.
    pub faces: u32,
}

impl TreeData {
    /// The tree of a cube, without nodes yet.
    fn of(cube: &View) -> Self {
        let perspective = cube.projection() == Projection::Perspective;
        let scale = f64::from(cube.width) / f64::from(cube.far);
        let across = if perspective { f64::from(cube.scale_x) * f64::from(cube.width) / 2.0 } else { 1.0 };
        let scaled = |axis: [f32; 3], by: f64| axis.map(|a| (f64::from(a) * scale * by) as f32);
        let half = if perspective { 0.0 } else { f64::from(cube.far) / 2.0 };
        let corner = |i: usize| f64::from(cube.origin[i]) - half * (f64::from(cube.right[i]) + f64::from(cube.up[i]));
        Self {
            origin: [0, 1, 2].map(|i| corner(i) as f32),
            size: cube.width,
            right: scaled(cube.right, across),
            levels: Shape { size: cube.width, tile: cube.width }.root_level() + 1,
            up: scaled(cube.up, across),
            forward: scaled(cube.forward, 1.0),
            perspective: perspective.into(),
            ..Self::zeroed()
        }
    }

    /// The trees of all lights, without nodes yet.
    pub(super) fn all(cubes: &Cubes) -> Vec<Self> {
        let mut trees: Vec<_> = cubes.views.iter().map(Self::of).collect();
        for (tree, light) in trees.iter_mut().zip(&cubes.lights) {
            (tree.first, tree.faces) = (light.start as u32, light.len() as u32);
        }
        trees
    }
}
