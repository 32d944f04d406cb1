//! Twin of glsl/world/gather.comp and gather_triangles.comp: what the caller's buffers become, to the bit but for axes of strands
//! so short that a device may flush them.

use crate::scene::Caster;

/// Where a caster has what of it counts, words from its start.
#[derive(Clone, Copy, Debug)]
pub struct CasterAt {
    /// Where the first of them is, words from the buffer's start.
    pub start: usize,
    /// From one to the next.
    pub stride: usize,
    /// Three floats.
    pub position: usize,
    /// Three floats, of a strand; none for spheres.
    pub end: Option<usize>,
    /// Or of all.
    pub radius: Result<usize, f32>,
    /// Or of all.
    pub density: Result<usize, f32>,
}

/// The bits of an optical depth of 80. Twin: MOST_DEPTH.
const MOST_DEPTH: u32 = 0x42A0_0000;

/// Triangles after each other of which one may have a place. Twin: TRIES.
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

/// So many casters, the first `live` of them from `theirs`, and how many of those were refused.
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

/// Vertices of the caller's and what triangles they are.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<'a> {
    /// Their buffer.
    pub words: &'a [u32],
    /// Where the first vertex is, words.
    pub start: usize,
    /// From one to the next.
    pub stride: usize,
    /// That there are.
    pub count: usize,
    /// Three a triangle; without, vertices stand in threes.
    pub indices: Option<&'a [u32]>,
    /// Albedo of all triangles.
    pub albedo: [f32; 3],
    /// Where nothing has a place.
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

    /// So many triangles, three corners and the albedo, the first `live` of them theirs, and how many of those were refused.
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
