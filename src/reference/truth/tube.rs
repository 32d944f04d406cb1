//! Whether a triangle meets any voxel that a ray may pass through, for any position of the voxel grid.

use super::alpha::Coverage;
use super::meshes::{Meshes, Triangle};
use super::shaft::{Half, clip};
use bvh::aabb::{Aabb, IntersectsAabb};
use glam::DVec3;

/// The voxels around a ray whose texels may decide whether a triangle is put into a voxel that the ray passes through: a voxel and its
/// diagonal.
const ALPHA_REACH: f64 = 2.75;

/// A cube swept along a line: all points at most one voxel away from some point of the line, along each axis.
pub(super) struct Tube {
    middle: DVec3,
    /// Vector from the middle to either end of the line.
    half: DVec3,
    voxel: f64,
}

impl Tube {
    /// Creates a tube along the line from `start` to `start + way`.
    pub fn new(start: DVec3, way: DVec3, voxel: f64) -> Self {
        Self { middle: start + way / 2.0, half: way / 2.0, voxel }
    }

    /// Returns whether any triangle meets the tube, other than with holes alone.
    pub fn is_met(&self, meshes: &Meshes) -> bool {
        meshes
            .meeting(self)
            .any(|triangle| self.meets(triangle.corners) && (!triangle.has_alpha() || self.covers(triangle)))
    }

    /// Returns whether a triangle may block light anywhere in the tube. A pass that puts a triangle into a voxel looks at texels up to a
    /// voxel's diagonal beyond the voxel, and beyond the triangle's border.
    fn covers(&self, triangle: &Triangle) -> bool {
        let wide = Self { voxel: ALPHA_REACH * self.voxel, ..*self };
        let plane = triangle.plane(self.middle, 2.0 * self.half.length() + 8.0 * wide.voxel);
        let part = wide.faces().fold(plane, |part, axis| {
            let (middle, reach) = (axis.dot(self.middle), wide.reach(axis));
            let part = clip(part, Half { normal: axis, most: middle + reach });
            clip(part, Half { normal: -axis, most: reach - middle })
        });
        triangle.coverage(&part) != Coverage::None
    }

    /// Returns normals of all faces of the tube.
    fn faces(&self) -> impl Iterator<Item = DVec3> {
        let own = [DVec3::X, DVec3::Y, DVec3::Z, self.half];
        (0..4).flat_map(move |i| (i + 1..4).map(move |j| own[i].cross(own[j])))
    }

    /// Returns how far the tube extends from its middle along `axis`.
    fn reach(&self, axis: DVec3) -> f64 {
        self.voxel * axis.abs().element_sum() + self.half.dot(axis).abs()
    }

    /// Returns whether a triangle meets the tube. Two convex shapes are disjoint if they are separated along the normal of a face of either
    /// shape, or along the cross product of an edge of one with an edge of the other. Source: Gottschalk 1996, separating axes.
    fn meets(&self, corners: [DVec3; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| corner - self.middle);
        let apart = |axis: DVec3| {
            let along = [a, b, c].map(|corner| corner.dot(axis));
            let (low, high) = (along.into_iter().fold(f64::MAX, f64::min), along.into_iter().fold(f64::MIN, f64::max));
            let reach = self.reach(axis);
            low > reach || high < -reach
        };
        let edges = [b - a, c - b, a - c];
        let own = [DVec3::X, DVec3::Y, DVec3::Z, self.half];
        let crosses = edges.into_iter().flat_map(|edge| own.map(|axis| edge.cross(axis)));
        !std::iter::once(edges[0].cross(edges[1])).chain(self.faces()).chain(crosses).any(apart)
    }
}

impl IntersectsAabb<f64, 3> for Tube {
    /// Conservative: never returns false if the tube and the box overlap.
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        let vec = |p: &[f64]| DVec3::from_slice(p);
        let (low, high) = (vec(aabb.min.coords.as_slice()), vec(aabb.max.coords.as_slice()));
        let (offset, size) = ((low + high) / 2.0 - self.middle, (high - low) / 2.0);
        let half = self.half;
        [DVec3::X, DVec3::Y, DVec3::Z, half.cross(DVec3::X), half.cross(DVec3::Y), half.cross(DVec3::Z)]
            .into_iter()
            .all(|axis| offset.dot(axis).abs() <= self.reach(axis) + size.dot(axis.abs()))
    }
}
