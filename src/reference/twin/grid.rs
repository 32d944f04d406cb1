//! The grid of voxels occupied by meshes, and marches through it. Twin of glsl/grid/. Occupied voxels are bit-exact, since neither the twin
//! nor the device divides, fuses operations or changes their order.

pub(super) use crate::scene::Facet;
pub use crate::scene::{Bits, Place};

use std::array::from_fn;

impl Place {
    /// Returns the grid around all corners, with `fitted` voxels along the longest side of their box. It equals the device's grid up to the
    /// rounding of a division. Twin: glsl/grid/bounds.comp, fit.comp, and grid::voxels_per_side.
    pub fn about(corners: impl Iterator<Item = [f32; 3]>, fitted: u32) -> Self {
        let (low, high) = corners.fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
            (from_fn(|i| low[i].min(p[i])), from_fn(|i| high[i].max(p[i])))
        });
        let (low, high) = if low[0] > high[0] { ([0.0; 3], [0.0; 3]) } else { (low, high) };
        let most = |of: [f32; 3]| of[0].max(of[1]).max(of[2]);
        let far: [f32; 3] = from_fn(|i| low[i].abs().max(high[i].abs()));
        let widest = most(from_fn(|i| high[i] - low[i])).max(most(far).max(1.0) * 1e-3);
        let size = fitted.next_power_of_two().max(64);
        let voxel = widest / (fitted - 2) as f32;
        let origin = from_fn(|i| 0.5 * (low[i] + high[i]) - 0.5 * size as f32 * voxel);
        Self { origin, voxel, per_unit: (fitted - 2) as f32 / widest, size }
    }
}

impl Bits {
    /// Twin: grid_clip.
    fn clip(&self, from: [f32; 3], way: [f32; 3]) -> [f32; 2] {
        let (mut near, mut far) = (0.0f32, 1.0f32);
        for i in 0..3 {
            let inverse = 1.0 / if way[i] == 0.0 { 1e-20 } else { way[i] };
            let (low, high) = (-from[i] * inverse, (self.size as f32 - from[i]) * inverse);
            (near, far) = (near.max(low.min(high)), far.min(low.max(high)));
        }
        [near, far]
    }

    /// Like [`Bits::clip`], but `None` if the ray misses the grid.
    pub(super) fn clipped(&self, from: [f32; 3], way: [f32; 3]) -> Option<[f32; 2]> {
        Some(self.clip(from, way)).filter(|[near, far]| near <= far)
    }

    /// Visits all voxels along the ray in order, until `goes_on` returns false. `goes_on` receives each voxel, and the points where the ray
    /// enters and leaves it as fractions of the ray's length.
    pub(super) fn walk(&self, from: [f32; 3], way: [f32; 3], mut goes_on: impl FnMut([u32; 3], [f32; 2]) -> bool) {
        let Some([near, far]) = self.clipped(from, way) else { return };
        let last = self.size as i32 - 1;
        let at = |t: f32, i: usize| (from[i] + way[i] * t).floor();
        let mut voxel: [i32; 3] = from_fn(|i| (at(near, i) as i32).clamp(0, last));
        let mut begin = near;
        loop {
            let planes: [f32; 3] = from_fn(|i| {
                let plane = (voxel[i] + i32::from(way[i] > 0.0)) as f32;
                if way[i] == 0.0 { f32::INFINITY } else { (plane - from[i]) * (1.0 / way[i]) }
            });
            let axis = if planes[0] <= planes[1] && planes[0] <= planes[2] {
                0
            } else if planes[1] <= planes[2] {
                1
            } else {
                2
            };
            if !goes_on(voxel.map(|v| v as u32), [begin, planes[axis].min(far)]) || planes[axis] >= far {
                return;
            }
            begin = begin.max(planes[axis]);
            voxel[axis] += if way[axis] > 0.0 { 1 } else { -1 };
            if voxel[axis] < 0 || voxel[axis] > last {
                return;
            }
        }
    }

    /// Returns whether any voxel along the ray is occupied, visiting every voxel. Twin: march_exact in glsl/grid/march.glsl, which skips
    /// empty space.
    pub fn march_exact(&self, from: [f32; 3], way: [f32; 3]) -> bool {
        let mut met = false;
        self.walk(from, way, |voxel, _| {
            met = self.has(0, voxel);
            !met
        });
        met
    }

    /// Returns the voxel at a fraction `share` of the ray between `near` and `far`.
    pub(super) fn stepped(&self, from: [f32; 3], way: [f32; 3], [near, far]: [f32; 2], share: f32) -> [u32; 3] {
        let at = near * (1.0 - share) + far * share;
        from_fn(|i| ((from[i] + way[i] * at).floor() as i32).clamp(0, self.size as i32 - 1) as u32)
    }

    /// Twin: march_steps.
    pub fn march_steps(&self, from: [f32; 3], way: [f32; 3], steps: u32, offset: f32) -> bool {
        let Some(range) = self.clipped(from, way) else { return false };
        let mut shares = std::iter::once(0.0).chain((0..steps).map(|i| (i as f32 + offset) / steps as f32));
        shares.any(|share| self.has(0, self.stepped(from, way, range, share)))
    }
}
