//! The grid of voxels that meshes occupy, and ways through it. Twin of glsl/grid/: the same bits, since nothing in either is
//! divided, fused or put in another order.

pub use crate::scene::Place;

use std::array::from_fn;

/// Twin: GRID_SLACK in glsl/grid/overlap.glsl.
const SLACK: f32 = 1e-4;

impl Place {
    /// About all of these, as the device finds it but for its division. Twin: glsl/grid/bounds.comp, fit.comp.
    pub fn about(corners: impl Iterator<Item = [f32; 3]>, size: u32) -> Self {
        let (low, high) = corners.fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
            (from_fn(|i| low[i].min(p[i])), from_fn(|i| high[i].max(p[i])))
        });
        let (low, high) = if low[0] > high[0] { ([0.0; 3], [0.0; 3]) } else { (low, high) };
        let most = |of: [f32; 3]| of[0].max(of[1]).max(of[2]);
        let far: [f32; 3] = from_fn(|i| low[i].abs().max(high[i].abs()));
        let widest = most(from_fn(|i| high[i] - low[i])).max(most(far).max(1.0) * 1e-3);
        let voxel = widest / (size - 2) as f32;
        let origin = from_fn(|i| 0.5 * (low[i] + high[i]) - 0.5 * size as f32 * voxel);
        Self { origin, voxel, per_unit: (size - 2) as f32 / widest, size }
    }

    /// In voxels from the corner.
    pub fn voxels(&self, position: [f32; 3]) -> [f32; 3] {
        from_fn(|i| (position[i] - self.origin[i]) * self.per_unit)
    }
}

/// A triangle among voxels. Twin: Facet in glsl/grid/overlap.glsl.
pub(super) struct Facet {
    corners: [[f32; 3]; 3],
    edges: [[f32; 3]; 3],
    normal: [f32; 3],
    pub(super) first: [u32; 3],
    pub(super) last: [u32; 3],
    /// Voxels, or cells, are so much larger to each side.
    slack: f32,
    /// What its plane is not known by, in lengths of its normal times voxels.
    error: f32,
}

impl Facet {
    /// A triangle whose corners are in voxels, or in cells of which a voxel's side has so many.
    fn of(corners: [[f32; 3]; 3], size: u32, cells: u32) -> Self {
        Self::slack(corners, size, SLACK * cells as f32)
    }

    /// Where it is listed. Twin: glsl/grid/lists/meets.glsl.
    pub(super) fn listed(corners: [[f32; 3]; 3], size: u32) -> Self {
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

    /// Its box, larger by the slack. Twins: low_of, high_of.
    pub(super) fn bounds(&self) -> [[f32; 3]; 2] {
        let [a, b, c] = self.corners;
        [from_fn(|i| a[i].min(b[i].min(c[i])) - self.slack), from_fn(|i| a[i].max(b[i].max(c[i])) + self.slack)]
    }

    /// Whether it is one point, which casts nothing. Twin: facet_is_point.
    pub(super) fn is_point(&self) -> bool {
        self.edges == [[0.0; 3]; 3]
    }

    /// Whether it meets a voxel of its box. Source: Schwarz and Seidel 2010, section 3.
    pub(super) fn meets(&self, voxel: [u32; 3]) -> bool {
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

/// The bits of all levels. Twin: what glsl/grid/grid.glsl says of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bits {
    size: u32,
    /// Levels one behind the other, 64 bits per word.
    pub words: Vec<u64>,
}

/// Levels of bits.
const LEVELS: u32 = 3;

impl Bits {
    fn side(size: u32, level: u32) -> u32 {
        size >> (2 * level + 2)
    }

    /// None.
    pub(super) fn none(size: u32) -> Self {
        let words = (0..LEVELS).map(|level| Self::side(size, level).pow(3)).sum::<u32>();
        Self { size, words: vec![0; words as usize] }
    }

    /// The word of a level that a voxel is in, and its bit there.
    pub(super) fn place(&self, level: u32, voxel: [u32; 3]) -> (usize, u32) {
        let at = (0..level).map(|l| Self::side(self.size, l).pow(3)).sum::<u32>();
        let [x, y, z] = voxel.map(|v| v >> (2 * level + 2));
        let bit = voxel.map(|v| (v >> (2 * level)) & 3);
        let side = Self::side(self.size, level);
        ((at + (z * side + y) * side + x) as usize, bit[0] | bit[1] << 2 | bit[2] << 4)
    }

    /// Voxels of triangles whose corners are in voxels. Twin: glsl/grid/voxelize.comp.
    pub fn voxelize(triangles: impl Iterator<Item = [[f32; 3]; 3]>, size: u32) -> Self {
        Self::voxelize_cells(triangles, size, 1)
    }

    /// Voxels of triangles whose corners are in cells, of which a voxel's side has so many.
    pub(super) fn voxelize_cells(triangles: impl Iterator<Item = [[f32; 3]; 3]>, size: u32, cells: u32) -> Self {
        let mut bits = Self::none(size);
        for corners in triangles {
            let facet = Facet::of(corners, size, cells);
            if facet.is_point() {
                continue;
            }
            for z in facet.first[2]..=facet.last[2] {
                for y in facet.first[1]..=facet.last[1] {
                    for x in (facet.first[0]..=facet.last[0]).filter(|x| facet.meets([*x, y, z])) {
                        (0..LEVELS).for_each(|level| bits.set(level, [x, y, z]));
                    }
                }
            }
        }
        bits
    }

    pub(super) fn set(&mut self, level: u32, voxel: [u32; 3]) {
        let (word, bit) = self.place(level, voxel);
        self.words[word] |= 1 << bit;
    }

    /// Whether a voxel, or what stands for it on a level above, is occupied.
    pub fn has(&self, level: u32, voxel: [u32; 3]) -> bool {
        let (word, bit) = self.place(level, voxel);
        self.words[word] >> bit & 1 == 1
    }

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

    /// As [`Bits::clip`]; none where it passes by.
    pub(super) fn clipped(&self, from: [f32; 3], way: [f32; 3]) -> Option<[f32; 2]> {
        Some(self.clip(from, way)).filter(|[near, far]| near <= far)
    }

    /// Goes through all voxels on a way, one after the other, with where it enters and leaves each, for as long as `goes_on`.
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

    /// Whether any voxel on a way is occupied: all of them are asked, one after the other, and nothing is skipped. Twin:
    /// march_exact in glsl/grid/march.glsl, which skips what is empty.
    pub fn march_exact(&self, from: [f32; 3], way: [f32; 3]) -> bool {
        let mut met = false;
        self.walk(from, way, |voxel, _| {
            met = self.has(0, voxel);
            !met
        });
        met
    }

    /// The voxel that is such a share of the way from one place to another.
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
