//! A light's tree as look-ups read it: its placement, and where its nodes are stored.

use super::buffers::Shape;
use super::cube::Cubes;
use crate::scene::{Projection, View};
use bytemuck::{Pod, Zeroable};

/// Maximum number of levels in a tree. The lowest level has leaves, the next has bricks of 8 voxels per side, and the highest has nodes of
/// 65,536 voxels per side. Twin: Tree in glsl/technique/voxelized/tree.glsl.
pub const MAX_LEVELS: usize = 15;

/// A light's tree. Twin: Tree in glsl/technique/voxelized/tree.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TreeData {
    /// Corner of the cube, or position of the light if it has one, in world units.
    pub origin: [f32; 3],
    /// Voxels per side.
    pub size: u32,
    /// Voxels per world unit along the cube's x axis. For a light with a position, the dot product with a point's offset from the light is
    /// the column, counted from the centre, times the depth in voxels.
    pub right: [f32; 3],
    /// The root's level plus one.
    pub levels: u32,
    /// Same as `right`, but along the cube's y axis.
    pub up: [f32; 3],
    /// 1: all lit; 2: all shadowed; 3: there are nodes.
    pub root: u32,
    /// Voxels per world unit along the cube's z axis, the direction in which light travels.
    pub forward: [f32; 3],
    /// The root's node, in the form of a pointer.
    pub root_at: u32,
    /// Offset, in words, of the cells at which look-ups start instead of at the top levels.
    pub shortcuts: u32,
    /// Offset of each level's nodes, in words.
    pub at: [u32; MAX_LEVELS],
    /// Bits per pointer in the nodes of each level.
    pub pointer_bits: [u32; MAX_LEVELS],
    /// 1 if the light has a position.
    pub perspective: u32,
    /// In tree `i`, the index of the first tree of light `i`.
    pub first: u32,
    /// In tree `i`, the number of trees of light `i`; 0 if there is no such light.
    pub faces: u32,
}

impl TreeData {
    /// Returns the tree of a cube, without nodes yet.
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

    /// Returns the trees of all lights, without nodes yet.
    pub(super) fn all(cubes: &Cubes) -> Vec<Self> {
        let mut trees: Vec<_> = cubes.views.iter().map(Self::of).collect();
        for (tree, light) in trees.iter_mut().zip(&cubes.lights) {
            (tree.first, tree.faces) = (light.start as u32, light.len() as u32);
        }
        trees
    }
}
