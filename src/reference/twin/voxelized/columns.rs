//! From triangles to columns of voxels, and the depth at which the shadow in each column starts. Twin of
//! glsl/technique/voxelized/project.comp, facet.glsl and columns.comp.

/// Number of quantization steps per voxel for corner positions. Twin: SUB_VOXELS.
const SUB_VOXELS: f32 = 256.0;

/// Near plane of a pyramid, as a share of its depth. Twin: NEAREST.
const NEAREST: f32 = 1e-6;

/// The voxels of a light. For a directional light they form a cube, with the light shining along its last axis; this struct holds the
/// cube's corner, and its axes in voxels per world unit. For a light with a position they form a pyramid with the light at its apex. In a
/// pyramid the last coordinate is the depth in voxels, and the first two are the depth times the column, counted from the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube {
    /// Corner of the cube or apex of the pyramid, in world units.
    pub origin: [f32; 3],
    /// The cube's x, y and z axes.
    pub axes: [[f32; 3]; 3],
    /// Number of voxels per side.
    pub size: u32,
    /// Whether the voxels form a pyramid.
    pub perspective: bool,
}

/// A triangle projected onto the columns. Twin: glsl/technique/voxelized/projected.glsl.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// Corners across the columns, in 256ths of a voxel.
    pub corners: [[i64; 2]; 3],
    /// Depth of each corner along the light, in voxels. For a pyramid: 1 / depth at the centre of all columns, and its change per column to
    /// the right and up.
    pub z: [f32; 3],
    /// For a pyramid, the minimum and maximum depth, in voxels.
    pub range: Option<[f32; 2]>,
    /// Half the number of columns per side.
    pub half: f32,
    /// 1 if a ray along the triangle's normal leaves a closed surface, −1 if it enters one, 0 if the surface is open.
    pub side: i32,
}

/// Returns a position's coordinates along the cube's axes.
fn along(cube: &Cube, position: [f32; 3]) -> [f32; 3] {
    let offset = [0, 1, 2].map(|i| position[i] - cube.origin[i]);
    cube.axes.map(|axis| offset[0] * axis[0] + offset[1] * axis[1] + offset[2] * axis[2])
}

/// Returns the position in voxels for coordinates along the axes.
fn among(cube: &Cube, [x, y, z]: [f32; 3]) -> [f32; 3] {
    let half = 0.5 * cube.size as f32;
    if cube.perspective { [x / z + half, y / z + half, z] } else { [x, y, z] }
}

/// Converts a position to voxels. Twin: project in glsl/technique/voxelized/project.comp, with the same bits if the device divides exactly;
/// and tree_voxel.
pub fn voxel(cube: &Cube, position: [f32; 3]) -> [f32; 3] {
    among(cube, along(cube, position))
}

/// Projects a triangle; if the pyramid cuts it, the result has several pieces. Twin: glsl/technique/voxelized/project.comp.
pub fn project(cube: &Cube, corners: [[f32; 3]; 3], side: i32) -> Vec<Projected> {
    let at = corners.map(|corner| along(cube, corner));
    let whole = |v: f32| (v * SUB_VOXELS + 0.5).floor() as i64;
    let half = 0.5 * cube.size as f32;
    let projected = |at: [[f32; 3]; 3], z, range| {
        let corners = at.map(|v| among(cube, v)).map(|v| [whole(v[0]), whole(v[1])]);
        Projected { corners, z, range, half, side }
    };
    if !cube.perspective {
        return vec![projected(at, at.map(|v| v[2]), None)];
    }
    let polygon = cut(at.to_vec(), cube.size as f32);
    let depths = || polygon.iter().map(|v| v[2]);
    let range = [depths().fold(f32::INFINITY, f32::min), depths().fold(0.0, f32::max)];
    let [b, c] = [1, 2].map(|i| [0, 1, 2].map(|axis| at[i][axis] - at[0][axis]));
    let [x, y, z] = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    let away = x * at[0][0] + y * at[0][1] + z * at[0][2];
    let is_some = away.abs() > 0.0 && away.abs() < crate::scene::FARTHEST;
    let plane = if is_some { [z / away, x / away, y / away] } else { [1.0 / range[0], 0.0, 0.0] };
    let pieces = polygon.windows(2).skip(1);
    pieces.map(|pair| projected([polygon[0], pair[0], pair[1]], plane, Some(range))).collect()
}

/// Clips a polygon to the pyramid. Twin: put_pieces.
fn cut(polygon: Vec<[f32; 3]>, size: f32) -> Vec<[f32; 3]> {
    let planes: [fn([f32; 3], f32) -> f32; 5] = [
        |v, size| v[2] - NEAREST * size,
        |v, size| size * v[2] - v[0],
        |v, size| size * v[2] + v[0],
        |v, size| size * v[2] - v[1],
        |v, size| size * v[2] + v[1],
    ];
    planes.into_iter().fold(polygon, |polygon, inside| {
        let mut left = Vec::new();
        for (i, here) in polygon.iter().enumerate() {
            let next = &polygon[(i + 1) % polygon.len()];
            let (at_here, at_next) = (inside(*here, size), inside(*next, size));
            if at_here >= 0.0 {
                left.push(*here);
            }
            if (at_here >= 0.0) != (at_next >= 0.0) {
                let ((from, from_in), (to, to_in)) = if at_here >= 0.0 {
                    ((here, at_here), (next, at_next))
                } else {
                    ((next, at_next), (here, at_here))
                };
                let share = from_in / (from_in - to_in);
                left.push([0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * share));
            }
        }
        left
    })
}

/// Returns the entry and the exit of the shadow in every column, row after row. If `conservative`, a triangle meets a column if it touches
/// any part of the column's square, not only its centre. Twin: glsl/technique/voxelized/columns.comp, which uses two 32-bit words where
/// this uses one of 64 bits, and divides less exactly.
pub fn columns(triangles: &[Projected], size: u32, closed: bool, conservative: bool) -> Vec<[u32; 2]> {
    let facets: Vec<_> = triangles.iter().filter_map(Facet::of).collect();
    let mut met: Vec<Vec<(f32, i32)>> = vec![Vec::new(); (size * size) as usize];
    for facet in &facets {
        facet.columns(size, false, |column, z| met[column].push((z, if closed { facet.faces } else { 0 })));
    }
    if conservative {
        let nearest: Vec<_> =
            met.iter().map(|met| met.iter().fold(f32::INFINITY, |least, (z, _)| least.min(*z))).collect();
        let mut touched = vec![f32::INFINITY; met.len()];
        // Triangles that touch the column's square count only if they lie more than a voxel in front of all triangles that meet its centre.
        // Triangles that lie less far in front may be part of the same surface.
        for facet in &facets {
            facet.columns(size, true, |column, z| {
                if facet.range[1] + 1.0 < nearest[column] {
                    touched[column] = touched[column].min(z);
                }
            });
        }
        for (met, z) in met.iter_mut().zip(touched).filter(|(_, z)| z.is_finite()) {
            *met = vec![(z, 0)];
        }
    }
    met.into_iter().map(|surfaces| column(surfaces, size)).collect()
}

fn cross(a: [i64; 2], b: [i64; 2]) -> i64 {
    a[0] * b[1] - a[1] * b[0]
}

fn between(a: [i64; 2], b: [i64; 2]) -> [i64; 2] {
    [b[0] - a[0], b[1] - a[1]]
}

/// A triangle of non-zero area, with its corners in counter-clockwise order. Twin: glsl/technique/voxelized/facet.glsl.
struct Facet {
    corners: [[i64; 2]; 3],
    /// Depth at the first corner, in voxels.
    z: f32,
    /// Change of depth per 256th of a voxel to the right and up.
    slope: [f32; 2],
    /// For a pyramid only: first, 1 / depth at the centre of all columns and its change per column to the right and up; second, half the
    /// number of columns per side.
    plane: Option<([f32; 3], f32)>,
    /// Minimum and maximum z of the corners.
    range: [f32; 2],
    /// 1 if light enters a closed surface here, −1 if it leaves one, 0 if the surface is open.
    faces: i32,
}

impl Facet {
    fn of(triangle: &Projected) -> Option<Self> {
        let [a, mut b, mut c] = triangle.corners;
        let [z, mut z_b, mut z_c] = triangle.z;
        let turned = cross(between(a, b), between(a, c)) < 0;
        if turned {
            (b, c, z_b, z_c) = (c, b, z_c, z_b);
        }
        let area = cross(between(a, b), between(a, c));
        if area == 0 {
            return None;
        }
        let scale = 1.0 / area as f32;
        let [ab, ac] = [between(a, b), between(a, c)].map(|e| e.map(|v| v as f32));
        let (to_b, to_c) = (z_b - z, z_c - z);
        let slope = [(to_b * ac[1] - to_c * ab[1]) * scale, (to_c * ab[0] - to_b * ac[0]) * scale];
        let range = triangle.range.unwrap_or([z.min(z_b).min(z_c), z.max(z_b).max(z_c)]);
        let plane = triangle.range.map(|_| (triangle.z, triangle.half));
        Some(Self {
            corners: [a, b, c],
            z,
            slope,
            plane,
            range,
            faces: if turned { -triangle.side } else { triangle.side },
        })
    }

    /// Calls `found` with each column whose centre the triangle covers, and the depth there. With `squares`, calls it with each column
    /// whose square the triangle touches, and the largest depth over that square.
    fn columns(&self, size: u32, squares: bool, mut found: impl FnMut(usize, f32)) {
        let [a, b, c] = self.corners;
        let bounds = |axis: usize| {
            let all = [a[axis], b[axis], c[axis]];
            let low = all.into_iter().fold(i64::MAX, i64::min) + if squares { -1 } else { 127 };
            let high = all.into_iter().fold(i64::MIN, i64::max) + if squares { 256 } else { 128 };
            (low >> 8).clamp(0, size.into())..(high >> 8).clamp(0, size.into())
        };
        for y in bounds(1) {
            for x in bounds(0) {
                let is_met = [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
                    let edge = between(from, to);
                    // Tests the column's centre, or the corner of its square that is farthest inside this edge.
                    let inward = [if edge[1] < 0 { 256 } else { 0 }, if edge[0] > 0 { 256 } else { 0 }];
                    let [right, up] = if squares { inward } else { [128; 2] };
                    let value = cross(edge, between(from, [256 * x + right, 256 * y + up]));
                    value > 0 || (value == 0 && (squares || edge[1] < 0 || (edge[1] == 0 && edge[0] > 0)))
                });
                if is_met {
                    // Depths are computed from the corner of a block of 8 × 8 columns, to round as the device does.
                    let first = [x & !7, y & !7];
                    let steps = [(x - first[0]) as f32, (y - first[1]) as f32];
                    let base = between([256 * first[0] + 128, 256 * first[1] + 128], a).map(|v| v as f32);
                    let [right, up] = self.slope.map(|slope| slope * SUB_VOXELS);
                    let at_first = self.z - self.slope[0] * base[0] - self.slope[1] * base[1];
                    let farther = |right: f32, up: f32| if squares { 0.5 * (right.abs() + up.abs()) } else { 0.0 };
                    let z = if let Some(([middle, right, up], half)) = self.plane {
                        let [x, y] = first.map(|first| first as f32 + 0.5 - half);
                        let at_first = middle + right * x + up * y - farther(right, up);
                        let inverse = at_first + right * steps[0] + up * steps[1];
                        if inverse > 0.0 { 1.0 / inverse } else { self.range[1] }
                    } else {
                        at_first + farther(right, up) + right * steps[0] + up * steps[1]
                    };
                    found((y * i64::from(size) + x) as usize, z.clamp(self.range[0], self.range[1]));
                }
            }
        }
    }
}

/// Returns the entry and exit of a column that meets these surfaces, each given by its depth and its `faces` (see [`Facet`]).
fn column(mut surfaces: Vec<(f32, i32)>, size: u32) -> [u32; 2] {
    surfaces.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let Some(&(nearest, enters)) = surfaces.first() else { return [size; 2] };
    let whole = |z: f32| z.clamp(0.0, size as f32) as u32;
    let middle = whole((nearest + 0.5).floor());
    if enters <= 0 {
        return [middle; 2];
    }
    // Surfaces at the same depth count together.
    let mut inside = 0;
    let left = surfaces.chunk_by(|a, b| a.0 == b.0).find(|same| {
        inside += same.iter().map(|(_, faces)| faces).sum::<i32>();
        inside <= 0 && same.iter().any(|(_, faces)| *faces < 0)
    });
    let exit = left.map_or(size, |same| whole(same[0].0.floor()));
    let entry = whole(nearest.ceil());
    if exit < entry { [middle; 2] } else { [entry, exit] }
}

/// Where a shadow starts if it may do so anywhere between entry and exit. Twin: FREE in glsl/technique/voxelized/columns.comp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Free {
    /// At the exit.
    Exit,
    /// At the entry.
    Entry,
    /// At a depth shared by as many columns of a block as possible.
    Shared,
}

/// Returns the number in [low, high] with the most trailing zeros. Twin: roundest.
pub fn roundest(low: u32, high: u32) -> u32 {
    if low == 0 { 0 } else { high & !((1 << ((low - 1) ^ high).ilog2()) - 1) }
}

/// Returns the depth at which the shadow starts in each column. Twin: the end of glsl/technique/voxelized/columns.comp.
pub fn boundaries(columns: &[[u32; 2]], size: u32, free: Free) -> Vec<u32> {
    match free {
        Free::Exit => columns.iter().map(|c| c[1]).collect(),
        Free::Entry => columns.iter().map(|c| c[0]).collect(),
        Free::Shared => {
            let mut boundaries = vec![0; columns.len()];
            for block in 0..(size / 8).pow(2) {
                let mut open: Vec<_> = (0..64).map(|c| place(size, block, c)).collect();
                while let Some(stop) = open.iter().map(|i| columns[*i][1]).min() {
                    let (here, rest): (Vec<_>, _) = open.into_iter().partition(|i| columns[*i][0] <= stop);
                    let begin = here.iter().map(|i| columns[*i][0]).max().unwrap_or(stop);
                    here.into_iter().for_each(|i| boundaries[i] = roundest(begin, stop));
                    open = rest;
                }
            }
            boundaries
        }
    }
}

/// Returns the index of column `c` of a block of 8 × 8, among all columns.
pub(super) fn place(size: u32, block: u32, c: u32) -> usize {
    let across = size / 8;
    let (x, y) = (8 * (block % across) + c % 8, 8 * (block / across) + c / 8);
    (y * size + x) as usize
}
