//! Twin of glsl/world/gather.comp, gather_splats.comp, gather_triangles.comp and gather_lights.comp: casters, triangles and lights read
//! from the caller's buffers. The twin is bit-exact with three exceptions. A device may flush the axes of very short strands to 0. Splats
//! differ by the rounding of roots, logarithms and powers. Lights differ by the rounding of quotients.

use super::segment::MAX_OPTICAL_DEPTH;
use super::splat::{OCTAVES, REACH, ROOT_TWO_PI, axes_packed};
use crate::scene::Caster;
use glam::{Mat3, Quat, Vec4};

/// Layout of casters in the caller's buffer. Fields give the offset of a value in words from the caster's start.
#[derive(Clone, Copy, Debug)]
pub struct CasterAt {
    /// Offset of the first caster, in words from the buffer's start.
    pub start: usize,
    /// Number of words from one caster to the next.
    pub stride: usize,
    /// Offset of the position: three floats.
    pub position: usize,
    /// Offset of a strand's end: three floats; `None` for spheres.
    pub end: Option<usize>,
    /// Offset of the radius, or one radius for all casters.
    pub radius: Result<usize, f32>,
    /// Offset of the density, or one density for all casters.
    pub density: Result<usize, f32>,
}

/// Bit pattern of the float 80, the largest optical depth of a strand. Twin: MOST_DEPTH.
const MOST_DEPTH: u32 = 0x42A0_0000;

/// Number of triangles tried when looking for a place for a refused triangle. Twin: TRIES.
const TRIES: usize = 16;

fn is_finite(bits: [u32; 3]) -> bool {
    bits.iter().all(|b| f32::from_bits(*b).is_finite())
}

fn is_positive(bits: u32) -> bool {
    f32::from_bits(bits).is_finite() && f32::from_bits(bits) > 0.0
}

fn is_not_negative(bits: u32) -> bool {
    f32::from_bits(bits).is_finite() && f32::from_bits(bits) >= 0.0
}

fn three(words: &[u32], at: usize) -> [u32; 3] {
    [words[at], words[at + 1], words[at + 2]]
}

/// Gathers `slots` casters, the first `live` of them from the caller's words `theirs`, and counts how many of the caller's casters were
/// refused.
pub fn casters(theirs: &[u32], at: &CasterAt, slots: usize, live: usize) -> (Vec<Caster>, u32) {
    let nothing = Caster { position: [0.0; 3], radius: 0.0, axis: [0.0; 3], density: 0.0 };
    let mut refused = 0;
    let caster = |i: usize| {
        if i >= live {
            return nothing;
        }
        let from = at.start + i * at.stride;
        let number = |n: Result<usize, f32>| n.map_or_else(f32::to_bits, |word| theirs[from + word]);
        let (place, radius, mut density) = (three(theirs, from + at.position), number(at.radius), number(at.density));
        let mut stands = is_finite(place) && is_positive(radius) && is_not_negative(density);
        let mut axis = [0.0; 3];
        if let Some(end) = at.end {
            let tip = three(theirs, from + end);
            axis = [0, 1, 2].map(|i| f32::from_bits(tip[i]) - f32::from_bits(place[i]));
            stands &= is_finite(tip) && is_finite(axis.map(f32::to_bits)) && axis != [0.0; 3];
            density = if density == (-0.0f32).to_bits() { density } else { density.min(MOST_DEPTH) };
        }
        if !stands {
            refused += 1;
            return nothing;
        }
        let [position, radius, density] = [place, [radius; 3], [density; 3]].map(|bits| bits.map(f32::from_bits));
        Caster { position, radius: radius[0], axis, density: density[0] }
    };
    let all = (0..slots).map(caster).collect();
    (all, refused)
}

/// Layout of splats in the caller's buffer. Fields give the offset of a value in words from the splat's start.
#[derive(Clone, Copy, Debug)]
pub struct SplatWords {
    /// Offset of the first splat, in words from the buffer's start.
    pub start: usize,
    /// Number of words from one splat to the next.
    pub stride: usize,
    /// Offset of the position: three floats.
    pub position: usize,
    /// Offset of the deviations: three floats.
    pub deviations: usize,
    /// Offset of the rotation: four floats.
    pub rotation: usize,
    /// Offset of the opacity, or one opacity for all splats.
    pub opacity: Result<usize, f32>,
}

/// Twin: depth_of.
fn depth_of(o: f32) -> f32 {
    let little = o * (1.0 + o * (1.0 / 2.0 + o * (1.0 / 3.0 + o * (1.0 / 4.0))));
    if o < 0.03 {
        little
    } else if o < 1.0 {
        (-(1.0 - o).ln()).min(MAX_OPTICAL_DEPTH)
    } else {
        MAX_OPTICAL_DEPTH
    }
}

/// Twin: octaves_of.
fn octaves_of(longest: f32, other: f32) -> u32 {
    (((longest / other).log2() * (4095.0 / OCTAVES)).clamp(0.0, 4095.0) + 0.5) as u32
}

/// Reads one splat; `None` if its position, sizes, rotation or opacity is invalid.
fn splat(theirs: &[u32], from: usize, at: &SplatWords) -> Option<Caster> {
    let float = |word: usize| f32::from_bits(theirs[from + word]);
    let (place, sizes) = (three(theirs, from + at.position), three(theirs, from + at.deviations));
    let turn = Vec4::from_array([0, 1, 2, 3].map(|i| float(at.rotation + i)));
    let share = at.opacity.map_or_else(|opacity| opacity, float);
    let square = turn.dot(turn);
    let stands = is_finite(place)
        && sizes.into_iter().all(is_positive)
        && turn.is_finite()
        && is_positive(square.to_bits())
        && is_not_negative(share.to_bits())
        && share <= 1.0;
    if !stands {
        return None;
    }
    let axes = Mat3::from_quat(Quat::from_vec4(turn / square.sqrt()));
    let long = sizes.map(f32::from_bits);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| long[*b].total_cmp(&long[*a]));
    let [longest, middle, shortest] = order;
    let short_by = octaves_of(long[longest], long[shortest]);
    let octaves = octaves_of(long[longest], long[middle]) | short_by << 12;
    let low = axes_packed(axes.col(shortest), axes.col(longest));
    let axis = [0, 1, 2].map(|i| {
        let byte = octaves >> (8 * i) & 255;
        f32::from_bits((byte & 128) << 24 | 0x7180_0000 | (byte & 127) << 16 | low[i])
    });
    let radius = REACH * long[longest];
    let thick = radius * (1.0 / REACH) * (short_by as f32 * (-OCTAVES / 4095.0)).exp2();
    let density = depth_of(share) / (ROOT_TWO_PI * thick);
    let caster = Caster { position: place.map(f32::from_bits), radius, axis, density };
    (radius.is_finite() && density.is_finite()).then_some(caster)
}

/// Gathers `slots` casters, the first `live` of them splats from the caller's words `theirs`, and counts how many of these splats were
/// refused. Twin: gather_splats.comp.
pub fn splats(theirs: &[u32], at: &SplatWords, slots: usize, live: usize) -> (Vec<Caster>, u32) {
    let nothing = Caster { position: [0.0; 3], radius: 0.0, axis: [0.0; 3], density: 0.0 };
    let found: Vec<_> = (0..live.min(slots)).map(|i| splat(theirs, at.start + i * at.stride, at)).collect();
    let refused = found.iter().filter(|splat| splat.is_none()).count() as u32;
    let mut all: Vec<_> = found.into_iter().map(|splat| splat.unwrap_or(nothing)).collect();
    all.resize(slots, nothing);
    (all, refused)
}

/// The caller's vertices, and the triangles that they form.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<'a> {
    /// The caller's buffer of vertices.
    pub words: &'a [u32],
    /// Offset of the first vertex, in words.
    pub start: usize,
    /// Number of words from one vertex to the next.
    pub stride: usize,
    /// Number of vertices.
    pub count: usize,
    /// Three indices per triangle; without indices, every three vertices are a triangle.
    pub indices: Option<&'a [u32]>,
    /// Albedo of all triangles.
    pub albedo: [f32; 3],
    /// Position of refused triangles if no valid one is found.
    pub place: [f32; 3],
}

impl Vertices<'_> {
    fn corner(&self, i: usize) -> Option<[f32; 3]> {
        let vertex = self.indices.map_or(i, |indices| indices[i] as usize);
        let bits = (vertex < self.count).then(|| three(self.words, self.start + vertex * self.stride))?;
        is_finite(bits).then(|| bits.map(f32::from_bits))
    }

    fn triangle(&self, i: usize) -> Option<[[f32; 3]; 3]> {
        Some([self.corner(3 * i)?, self.corner(3 * i + 1)?, self.corner(3 * i + 2)?])
    }

    /// Gathers `slots` triangles, each as three corners and the albedo, and counts how many of the caller's were refused; only the first
    /// `live` are the caller's.
    pub fn triangles(&self, slots: usize, live: usize) -> (Vec<[[f32; 3]; 4]>, u32) {
        let mut refused = 0;
        let triangle = |i: usize| {
            let whole = if i < live { self.triangle(i) } else { None };
            refused += u32::from(i < live && whole.is_none());
            let [a, b, c] = whole.unwrap_or_else(|| {
                let other = (0..TRIES.min(live)).find_map(|t| self.triangle((i + t) % live));
                [other.map_or(self.place, |corners| corners[0]); 3]
            });
            [a, b, c, self.albedo]
        };
        let all = (0..slots).map(triangle).collect();
        (all, refused)
    }
}

/// Layout of a light in the caller's buffer. Fields give the offset of a value in words from the light's start.
#[derive(Clone, Copy, Debug)]
pub struct LightWords {
    /// Offset of the position: three floats.
    pub position: usize,
    /// Offset of the direction: three floats.
    pub direction: usize,
    /// Offset of the radiance: three floats.
    pub radiance: usize,
    /// Offset of the radius, or one radius for all lights.
    pub radius: Result<usize, f32>,
    /// Offset of the cone's cosine, or one cosine for all lights.
    pub cos_cone: Result<usize, f32>,
}

/// A gathered light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatheredLight {
    /// Position; 0 for a directional light.
    pub position: [f32; 3],
    /// Direction; 0 for a point light.
    pub direction: [f32; 3],
    /// Cosine of half the cone of a spot light; 0 for a virtual light, −2 for all other lights.
    pub cos_cone: f32,
    /// Radiance in linear RGB.
    pub radiance: [f32; 3],
    /// 1 / radius², or 0 for lights of unlimited reach.
    pub falloff: f32,
}

/// Twins: UNIT, LEAST_RADIUS, MOST_RADIUS and WIDEST.
const UNIT: f32 = 2e-3;
const LEAST_RADIUS: f32 = 1e-18;
const MOST_RADIUS: f32 = 1e18;
const WIDEST: f32 = 0.087_155_7;

/// Reads the light of this kind (0 directional, 1 spot, 2 point, 3 virtual) that starts at word `from`; `None` if one of its numbers is not
/// finite or is out of range. Twin: gather_lights.comp.
pub fn light(theirs: &[u32], from: usize, at: &LightWords, kind: u32) -> Option<GatheredLight> {
    let vector = |word: usize| three(theirs, from + word).map(f32::from_bits);
    let number = |n: Result<usize, f32>| n.map_or_else(|is| is, |word| f32::from_bits(theirs[from + word]));
    let (position, direction, radiance) = (vector(at.position), vector(at.direction), vector(at.radiance));
    let (radius, cos_cone) = (number(at.radius), number(at.cos_cone));
    let square: f32 = direction.iter().map(|d| d * d).sum();
    let place = position.iter().all(|p| p.is_finite()) && radius >= LEAST_RADIUS && (kind != 3 || radius.is_finite());
    let way = (square - 1.0).abs() <= UNIT;
    let cone = (WIDEST..1.0).contains(&cos_cone);
    let (has_place, has_way) = (kind != 0, kind != 2);
    let shines = radiance.iter().all(|c| is_not_negative(c.to_bits()));
    if !(shines && (place || !has_place) && (way || !has_way) && (cone || kind != 1)) {
        return None;
    }
    let falloff = if has_place && radius < MOST_RADIUS { 1.0 / (radius * radius) } else { 0.0 };
    Some(GatheredLight {
        position: if has_place { position } else { [0.0; 3] },
        direction: if has_way { direction } else { [0.0; 3] },
        cos_cone: [-2.0, cos_cone, -2.0, 0.0][kind as usize],
        radiance,
        falloff,
    })
}
