//! The placement of a grid, as far as the host knows it.

use crate::world::World;
use glam::DVec3;

/// A grid around all casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    low: DVec3,
    high: DVec3,
    size: u32,
    /// Side of a voxel, in world units.
    pub voxel: f64,
}

impl Placement {
    /// Returns the placement of a grid of `size` voxels per side; None if the host does not know the box around all casters.
    pub fn known(world: &World, size: u32) -> Option<Self> {
        let [low, high] = world.known_box()?;
        let widest = (high - low).max_element().max(1e-3 * low.abs().max(high.abs()).max_element().max(1.0));
        // Slightly larger than on the device, to allow for rounding.
        let voxel = widest / f64::from(size - 2) * (1.0 + 1e-5);
        Some(Self { low, high, size, voxel })
    }

    /// Returns the error bound for the rounding of a ray's or a triangle edge's position in the grid, in world units. Twin: grid_rounding
    /// in glsl/grid/march_triangles.glsl.
    pub fn rounding(&self) -> f64 {
        let side = self.voxel * f64::from(self.size);
        let middle = 0.5 * (self.low + self.high);
        let far = middle.abs().max_element() + 0.5 * side;
        side / 524_288.0 + far / 2_097_152.0
    }
}
