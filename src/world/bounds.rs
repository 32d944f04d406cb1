//! The box around all casters, bit-identical to the result of glsl/grid/bounds.comp. A grid keeps its placement as long as the box stays
//! the same.

use crate::scene::{Caster, Mesh};
use glam::{DVec3, Vec3};

/// A box; low exceeds high if the box is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    /// The empty box.
    pub(super) const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Creates a box from its low and high corners.
    pub(super) fn of([low, high]: [Vec3; 2]) -> Self {
        Self { low, high }
    }

    /// Returns the low and high corners.
    pub(super) fn ends(self) -> [DVec3; 2] {
        [self.low.as_dvec3(), self.high.as_dvec3()]
    }

    /// Returns all eight corners.
    pub(super) fn corners(self) -> [[f32; 3]; 8] {
        std::array::from_fn(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] }))
    }

    /// Returns the box around the corners of triangles.
    pub(super) fn of_meshes(meshes: &[Mesh]) -> Self {
        let mut bounds = Self::NONE;
        for mesh in meshes {
            for i in mesh.triangles.iter().flatten() {
                bounds.include(mesh.positions.get(*i as usize).copied().unwrap_or_default().into(), 0.0);
            }
        }
        bounds
    }

    /// Returns the box around smoke and hair.
    pub(super) fn of_casters(casters: &[Caster]) -> Self {
        let mut bounds = Self::NONE;
        for caster in casters {
            let position = Vec3::from(caster.position);
            bounds.include(position, caster.radius);
            if caster.is_strand() {
                bounds.include(position + Vec3::from(caster.axis), caster.radius);
            }
        }
        bounds
    }

    fn include(&mut self, centre: Vec3, radius: f32) {
        self.low = self.low.min(centre - radius);
        self.high = self.high.max(centre + radius);
    }

    /// Returns the box around both boxes.
    pub(super) fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}
