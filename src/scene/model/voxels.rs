//! Voxels overlapped by triangles. Particles of `fountain` bounce off them, and tests compare them with the device's. Bit-identical twin of
//! glsl/grid/overlap.glsl and voxelize.comp: neither twin divides, fuses or reorders operations.

use std::array::from_fn;

/// Twin: GRID_SLACK in glsl/grid/overlap.glsl.
const SLACK: f32 = 1e-4;

/// The placement of a voxel grid in the world. Twin: Grid in glsl/grid/grid.glsl.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The grid's low corner, in world units.
    pub origin: [f32; 3],
    /// Side of a voxel, in world units.
    pub voxel: f32,
    /// Number of voxels per world unit.
    pub per_unit: f32,
    /// Number of voxels per side.
    pub size: u32,
}

impl Place {
    /// Converts a position to voxels from the grid's corner.
    pub fn voxels(&self, position: [f32; 3]) -> [f32; 3] {
        from_fn(|i| (position[i] - self.origin[i]) * self.per_unit)
    }
}

/// A triangle among voxels. Twin: Facet in glsl/grid/overlap.glsl.
pub(crate) struct Facet {
    corners: [[f32; 3]; 3],
    edges: [[f32; 3]; 3],
    normal: [f32; 3],
    pub(crate) first: [u32; 3],
    pub(crate) last: [u32; 3],
    /// Distance by which voxels, or cells, are enlarged on each side.
    slack: f32,
    /// Rounding error bound of the triangle's plane equation, in voxels times the length of its normal.
    error: f32,
}

impl Facet {
    /// Creates a triangle from corners given in voxels, or in cells; a voxel has `cells` cells per side.
    fn of(corners: [[f32; 3]; 3], size: u32, cells: u32) -> Self {
        Self::slack(corners, size, SLACK * cells as f32)
    }

    /// Creates a triangle for the voxels' lists, with more slack. Twin: glsl/grid/lists/meets.glsl.
    pub(crate) fn listed(corners: [[f32; 3]; 3], size: u32) -> Self {
        let facet = Self::slack(corners, size, 1.0 / 512.0);
        let side = facet.edges.as_flattened().iter().fold(0.0f32, |side, c| side.max(c.abs()));
        Self { error: 1.0 / 262_144.0 * (side * side) * (side + 2.0), ..facet }
    }

    fn slack(corners: [[f32; 3]; 3], size: u32, slack: f32) -> Self {
        let [a, b, c] = corners;
        let between = |from: [f32; 3], to: [f32; 3]| -> [f32; 3] { from_fn(|i| to[i] - from[i]) };
        let edges = [between(a, b), between(b, c), between(c, a)];
        let [ab, bc, _] = edges;
        let normal = [ab[1] * bc[2] - ab[2] * bc[1], ab[2] * bc[0] - ab[0] * bc[2], ab[0] * bc[1] - ab[1] * bc[0]];
        let whole = |v: f32| v.floor().clamp(0.0, (size - 1) as f32) as u32;
        let first = from_fn(|i| whole(a[i].min(b[i].min(c[i])) - slack));
        let last = from_fn(|i| whole(a[i].max(b[i].max(c[i])) + slack));
        Self { corners, edges, normal, first, last, slack, error: 0.0 }
    }

    /// Returns the triangle's box, enlarged by the slack. Twins: low_of, high_of.
    pub(crate) fn bounds(&self) -> [[f32; 3]; 2] {
        let [a, b, c] = self.corners;
        [from_fn(|i| a[i].min(b[i].min(c[i])) - self.slack), from_fn(|i| a[i].max(b[i].max(c[i])) + self.slack)]
    }

    /// Returns whether all corners coincide, so that the triangle casts no shadow. Twin: facet_is_point.
    pub(crate) fn is_point(&self) -> bool {
        self.edges == [[0.0; 3]; 3]
    }

    /// Returns whether the triangle overlaps a voxel that lies in its box. Source: Schwarz and Seidel 2010, section 3.
    pub(crate) fn meets(&self, voxel: [u32; 3]) -> bool {
        let corner = voxel.map(|v| v as f32);
        let seen: [[f32; 3]; 3] = self.corners.map(|c| from_fn(|i| c[i] - corner[i]));
        let [x, y, z] = self.normal;
        let plane = x * seen[0][0] + y * seen[0][1] + z * seen[0][2];
        let most = x.max(0.0) + y.max(0.0) + z.max(0.0);
        let least = x.min(0.0) + y.min(0.0) + z.min(0.0);
        let slack = self.slack * (x.abs() + y.abs() + z.abs()) + self.error;
        if most + slack - plane < 0.0 || plane - least + slack < 0.0 {
            return false;
        }
        let turn = self.normal.map(|n| if n >= 0.0 { 1.0 } else { -1.0 });
        (0..3).all(|i| {
            [[0, 1, 2], [1, 2, 0], [2, 0, 1]].into_iter().all(|[across, up, along]| {
                let (edge, from) = (self.edges[i], seen[i]);
                inside_edge([from[across], from[up]], [edge[across], edge[up]], turn[along], self.slack)
            })
        })
    }
}

/// Twin: inside_edge.
fn inside_edge(from: [f32; 2], edge: [f32; 2], turn: f32, slack: f32) -> bool {
    let (x, y) = (edge[1] * turn, edge[0] * turn);
    let at = x * from[0] - y * from[1];
    let reach = (-x).max(0.0) + y.max(0.0);
    let slack = slack * (x.abs() + y.abs());
    at + reach + slack >= 0.0
}

/// The occupancy bits of all levels, in the layout of glsl/grid/grid.glsl.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bits {
    pub(crate) size: u32,
    /// All levels in order, 64 bits per word.
    pub words: Vec<u64>,
}

/// Number of levels.
const LEVELS: u32 = 3;

impl Bits {
    fn side(size: u32, level: u32) -> u32 {
        size >> (2 * level + 2)
    }

    /// Creates a grid with no bits set.
    pub(crate) fn none(size: u32) -> Self {
        let words = (0..LEVELS).map(|level| Self::side(size, level).pow(3)).sum::<u32>();
        Self { size, words: vec![0; words as usize] }
    }

    /// Returns the word and bit of a voxel on a level.
    pub(crate) fn place(&self, level: u32, voxel: [u32; 3]) -> (usize, u32) {
        let at = (0..level).map(|l| Self::side(self.size, l).pow(3)).sum::<u32>();
        let [x, y, z] = voxel.map(|v| v >> (2 * level + 2));
        let bit = voxel.map(|v| (v >> (2 * level)) & 3);
        let side = Self::side(self.size, level);
        ((at + (z * side + y) * side + x) as usize, bit[0] | bit[1] << 2 | bit[2] << 4)
    }

    /// Returns the voxels that triangles overlap; corners are given in voxels. Twin: glsl/grid/voxelize.comp.
    pub fn voxelize(triangles: impl Iterator<Item = [[f32; 3]; 3]>, size: u32) -> Self {
        Self::voxelize_where(triangles, size, |_, _| true)
    }

    /// Like [`Bits::voxelize`], for triangles with holes: `blocks` returns whether a triangle, given by its index, may block light in a voxel.
    pub fn voxelize_where(
        triangles: impl Iterator<Item = [[f32; 3]; 3]>,
        size: u32,
        blocks: impl Fn(usize, [u32; 3]) -> bool,
    ) -> Self {
        Self::voxelize_cells(triangles, size, 1, blocks)
    }

    /// Returns the cells that triangles overlap; corners are given in cells, and a voxel has `cells` cells per side.
    pub(crate) fn voxelize_cells(
        triangles: impl Iterator<Item = [[f32; 3]; 3]>,
        size: u32,
        cells: u32,
        blocks: impl Fn(usize, [u32; 3]) -> bool,
    ) -> Self {
        let mut bits = Self::none(size);
        for (number, corners) in triangles.enumerate() {
            let facet = Facet::of(corners, size, cells);
            if facet.is_point() {
                continue;
            }
            for z in facet.first[2]..=facet.last[2] {
                for y in facet.first[1]..=facet.last[1] {
                    let occupies = |x: &u32| facet.meets([*x, y, z]) && blocks(number, [*x, y, z]);
                    for x in (facet.first[0]..=facet.last[0]).filter(occupies) {
                        (0..LEVELS).for_each(|level| bits.set(level, [x, y, z]));
                    }
                }
            }
        }
        bits
    }

    pub(crate) fn set(&mut self, level: u32, voxel: [u32; 3]) {
        let (word, bit) = self.place(level, voxel);
        self.words[word] |= 1 << bit;
    }

    /// Returns whether a voxel, or the brick or block that contains it on a higher level, is occupied.
    pub fn has(&self, level: u32, voxel: [u32; 3]) -> bool {
        let (word, bit) = self.place(level, voxel);
        self.words[word] >> bit & 1 == 1
    }
}
