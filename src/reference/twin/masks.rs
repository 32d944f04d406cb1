//! Masks: the cells of occupied voxels. Twin of glsl/grid/number.comp, mask.comp and masks.glsl, with identical words. The twin uses a grid
//! four times as fine, in which only the words of occupied voxels count.

use super::grid::Bits;

/// Number of cells per side of a voxel. Twin: FACET_CELLS in glsl/grid/occupy_cell.glsl.
const SIDE: u32 = 4;

/// Masks of a grid's voxels.
pub struct Masks {
    /// In the layout of glsl/grid/masks.glsl: the number of occupied voxels before each brick, then the masks of all occupied voxels.
    pub words: Vec<u32>,
    fine: Bits,
}

impl Masks {
    /// Builds the masks of triangles whose corners are given in voxels; `bits` marks the voxels that they meet.
    pub fn new(bits: &Bits, triangles: impl Iterator<Item = [[f32; 3]; 3]>, size: u32) -> Self {
        Self::new_where(bits, triangles, size, |_, _| true)
    }

    /// Like [`Masks::new`], for triangles with holes: `blocks` returns whether a triangle, given by its index, may block light in a cell.
    pub fn new_where(
        bits: &Bits,
        triangles: impl Iterator<Item = [[f32; 3]; 3]>,
        size: u32,
        blocks: impl Fn(usize, [u32; 3]) -> bool,
    ) -> Self {
        let cells = triangles.map(|t| t.map(|corner| corner.map(|c| SIDE as f32 * c)));
        let mut fine = Bits::voxelize_cells(cells, SIDE * size, SIDE, blocks);
        let (mut before, mut masks) = (Vec::new(), Vec::new());
        let side = size / 4;
        for brick in 0..side.pow(3) {
            before.push((masks.len() / 2) as u32);
            for bit in 0..64 {
                let voxel = [
                    4 * (brick % side) + bit % 4,
                    4 * (brick / side % side) + bit / 4 % 4,
                    4 * (brick / side.pow(2)) + bit / 16,
                ];
                let word = &mut fine.words[((voxel[2] * size + voxel[1]) * size + voxel[0]) as usize];
                if bits.has(0, voxel) {
                    masks.extend([*word as u32, (*word >> 32) as u32]);
                } else {
                    // Any cells in a voxel that is not occupied come from rounding.
                    *word = 0;
                }
            }
        }
        before.extend(masks);
        Self { words: before, fine }
    }

    /// Returns whether a cell is occupied.
    pub fn has(&self, cell: [u32; 3]) -> bool {
        self.fine.has(0, cell)
    }

    /// Returns whether any cell along the ray (given in voxels) is occupied, visiting every cell. Twin: march_exact in
    /// glsl/grid/march.glsl.
    pub fn march_exact(&self, from: [f32; 3], way: [f32; 3]) -> bool {
        let [from, way] = [from, way].map(|v| v.map(|c| SIDE as f32 * c));
        self.fine.march_exact(from, way)
    }
}
