//! Twins of glsl/technique/ism/areas.comp, scale.comp, sums.comp, offsets.comp and points.comp.

use super::map::{V3, dot, minus};

/// Twin: SUBSETS.
pub const SUBSETS: u32 = 16;

/// Twin: RUN.
const RUN: u32 = 32;

/// Twin: R2.
const R2: [u32; 2] = [3_242_174_889, 2_447_445_414];

/// Twin: ism_hash.
pub fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Twin: point_of.
pub fn point_of(light: u32, stratum: u32, points: u32) -> u32 {
    hash(hash(light).wrapping_add(stratum / RUN)) % SUBSETS * points + stratum
}

/// Returns the area of a triangle, or 0 if it is not finite. Twin: glsl/technique/ism/areas.comp.
pub fn area(corners: [V3; 3]) -> f32 {
    let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let area = 0.5 * dot(normal, normal).sqrt();
    if area <= 3e38 { area } else { 0.0 }
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

/// Twin: scale_of.
pub fn scale_of(area: f32) -> f32 {
    let exponent = (area.to_bits() >> 23) as i32 - 127;
    f32::from_bits(((127 + 29 - exponent.clamp(-96, 127)) as u32) << 23)
}

/// Returns prefix sums of the triangles' weights, each including the triangle itself. Twins: glsl/technique/ism/sums.comp, offsets.comp.
pub fn sums(areas: &[f32], scale: f32) -> Vec<u32> {
    let mut sum = 0;
    let next = |area: &f32| {
        sum += (area * scale + 0.5) as u32;
        sum
    };
    areas.iter().map(next).collect()
}

/// Returns a point on the meshes as its triangle and position; `None` if all triangles are degenerate.
/// Twin: glsl/technique/ism/points.comp.
pub fn point(triangles: &[[V3; 3]], sums: &[u32], index: u32, points: u32) -> Option<(usize, V3)> {
    let total = u64::from(*sums.last().filter(|total| **total > 0)?);
    let (subset, stratum) = (index / points, index % points);
    let before = |stratum: u32| total * u64::from(stratum) / u64::from(points);
    let wide = before(stratum + 1) - before(stratum);
    let weight = before(stratum) + ((u64::from(hash(index)) * wide) >> 32);
    let triangle = sums.partition_point(|sum| u64::from(*sum) <= weight);
    let rotated = [hash(subset), hash(subset + SUBSETS)];
    let mut at = [0, 1].map(|i| (stratum.wrapping_mul(R2[i]).wrapping_add(rotated[i]) >> 8) as f32 / 16_777_216.0);
    if at[0] + at[1] > 1.0 {
        at = at.map(|a| 1.0 - a);
    }
    let [a, b, c] = triangles[triangle];
    let (ab, ac) = (minus(b, a), minus(c, a));
    Some((triangle, [0, 1, 2].map(|i| a[i] + at[0] * ab[i] + at[1] * ac[i])))
}

/// Twins: HALVINGS, LONGER.
const HALVINGS: u32 = 20;
const LONGER: f32 = 1.01;

/// Returns the point at the fraction `weight` / `wide` of a space-filling curve through a triangle. Twin: place_at.
pub fn place_at(corners: [V3; 3], weight: u32, wide: u32) -> [f32; 2] {
    let places: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let (mut longest, mut most) = (0, 0.0);
    for i in 0..3 {
        let side = minus(corners[(i + 1) % 3], corners[i]);
        let square = dot(side, side);
        if square > LONGER * most {
            (longest, most) = (i, square);
        }
    }
    let [mut from, mut to, mut apex] = [0, 1, 2].map(|i| places[(longest + i) % 3]);
    let mut weight = weight;
    for _ in 0..HALVINGS {
        let middle = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
        weight *= 2;
        if weight < wide {
            to = apex;
        } else {
            weight -= wide;
            from = apex;
        }
        apex = middle;
    }
    apex
}

/// Like [`point`], for a pool of points in order along all triangles. Twin: glsl/technique/ism/points.comp, ISM_ADAPTIVE.
pub fn point_along(triangles: &[[V3; 3]], sums: &[u32], index: u32, points: u32) -> Option<(usize, V3)> {
    let total = u64::from(*sums.last().filter(|total| **total > 0)?);
    let before = |index: u32| total * u64::from(index) / u64::from(points * SUBSETS);
    let wide = before(index + 1) - before(index);
    let weight = before(index) + ((u64::from(hash(index)) * wide) >> 32);
    let triangle = sums.partition_point(|sum| u64::from(*sum) <= weight);
    let first = if triangle == 0 { 0 } else { sums[triangle - 1] };
    let [a, b, c] = triangles[triangle];
    let at = place_at([a, b, c], weight as u32 - first, sums[triangle] - first);
    let (ab, ac) = (minus(b, a), minus(c, a));
    Some((triangle, [0, 1, 2].map(|i| a[i] + at[0] * ab[i] + at[1] * ac[i])))
}

/// Twins: pack_normal's inverse, unpack_normal and point_closed.
pub fn unpack_normal(code: u32) -> (V3, bool) {
    let mut x = (code >> 17) as f32 / 32767.0 * 2.0 - 1.0;
    let mut y = (code >> 1 & 0xffff) as f32 / 65535.0 * 2.0 - 1.0;
    let z = 1.0 - x.abs() - y.abs();
    if z < 0.0 {
        let side = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
        (x, y) = ((1.0 - y.abs()) * side(x), (1.0 - x.abs()) * side(y));
    }
    let length = dot([x, y, z], [x, y, z]).sqrt();
    ([x / length, y / length, z / length], code & 1 != 0)
}
