//! Cells of a grid, and cones marched through them. Twin of glsl/grid/cells.comp (bit-exact) and of march_cone.glsl (up to rounding).

use super::grid::Bits;
use std::array::from_fn;

/// Twin: CONE_DARK in glsl/grid/march_cone.glsl.
const DARK: f32 = 1.0 / 256.0;

/// Twin: CONE_GAIN.
const GAIN: f32 = 1.34;

/// Number of occupied voxels in each cell of each level.
pub struct Cells {
    size: u32,
    /// Counts per cell on each level, from single voxels to the whole grid.
    levels: Vec<Vec<u32>>,
}

impl Cells {
    /// Builds the cells of the occupied voxels.
    pub fn new(bits: &Bits, size: u32) -> Self {
        let places = |side: u32| (0..side.pow(3)).map(move |i| [i % side, i / side % side, i / (side * side)]);
        let mut levels = vec![places(size).map(|voxel| u32::from(bits.has(0, voxel))).collect::<Vec<_>>()];
        for level in 1..=size.ilog2() {
            let (side, wide) = (size >> level, size >> (level - 1));
            let below = &levels[level as usize - 1];
            let child = |[x, y, z]: [u32; 3], i: u32| [2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2)];
            let count = |cell| {
                let at = |[x, y, z]: [u32; 3]| below[((z * wide + y) * wide + x) as usize];
                (0..8).map(|i| at(child(cell, i))).sum()
            };
            levels.push(places(side).map(count).collect());
        }
        Self { size, levels }
    }

    /// Returns the counts of the levels that the device stores: cells of 8 voxels per side and larger.
    pub fn counts(&self) -> Vec<u32> {
        self.levels.iter().skip(3).flatten().copied().collect()
    }

    /// Twin: cell_cover.
    fn cover(&self, level: usize, cell: [i32; 3]) -> f32 {
        let side = (self.size >> level) as i32;
        if cell.iter().any(|c| *c < 0 || *c >= side) {
            return 0.0;
        }
        let [x, y, z] = cell;
        let count = self.levels[level][((z * side + y) * side + x) as usize];
        (count as f32 / 4f32.powi(level as i32)).min(1.0)
    }

    /// Twin: march_cone.
    pub fn march_cone(&self, bits: &Bits, from: [f32; 3], way: [f32; 3], slope: f32) -> f32 {
        let voxels = way.iter().map(|w| w * w).sum::<f32>().sqrt();
        let Some([near, far]) = bits.clipped(from, way).filter(|_| voxels > 0.0) else { return 1.0 };
        let (mut at, mut light, mut side, mut level) = (near * voxels, 1.0f32, 1.0f32, 0usize);
        while at < far * voxels {
            while at * slope >= side && self.size >> level > 1 {
                (side, level) = (2.0 * side, level + 1);
            }
            let place: [f32; 3] = from_fn(|i| (from[i] + way[i] * (at / voxels)) / side - 0.5);
            let cover: f32 = (0..8)
                .map(|i| {
                    let offset = [i & 1, i >> 1 & 1, i >> 2];
                    let weight = |axis: usize| {
                        let share = place[axis] - place[axis].floor();
                        if offset[axis] == 1 { share } else { 1.0 - share }
                    };
                    let cell = from_fn(|axis| place[axis].floor() as i32 + offset[axis]);
                    weight(0) * weight(1) * weight(2) * self.cover(level, cell)
                })
                .sum();
            light *= (1.0 - GAIN * cover).max(0.0).sqrt();
            if light < DARK {
                return 0.0;
            }
            at += 0.5 * side;
        }
        light
    }
}
