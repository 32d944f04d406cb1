//! CPU twin of glsl/world/alpha.glsl, glsl/world/alpha_cover.glsl and glsl/maps/alpha_level.glsl: alpha at a point of a triangle, whether a
//! triangle may block light in a voxel, and the level of its texture for a map. The bits equal the device's, since every operation is
//! rounded once and in the same order.

use super::exact::{cross3, dot3, reciprocal};
use crate::scene::{Alpha, AlphaLevel, AlphaMode, AlphaTexture, Mesh, Projection, View, Wrap, alpha_levels};
use glam::{IVec2, Vec2, Vec3};
use std::sync::Arc;

/// Twin: MOST_TEXELS in glsl/world/alpha_cover.glsl.
const MOST_TEXELS: i32 = 256;
/// Twin: TEXEL_MARGIN in glsl/world/alpha_cover.glsl.
const TEXEL_MARGIN: f32 = 1.0 / 1024.0;

/// Twin: ALPHA_LAST_LEVEL in glsl/maps/alpha_level.glsl.
const LAST_LEVEL: u32 = 3;

/// Alpha of a triangle. Twin: Alpha in glsl/world/alpha.glsl.
#[derive(Clone, Debug)]
pub struct TriangleAlpha {
    mode: AlphaMode,
    uvs: [Vec2; 3],
    factors: [f32; 3],
    texture: Option<Arc<AlphaTexture>>,
    /// The triangle's number, if random numbers take the cutoff's place.
    hashed: Option<u32>,
}

/// Returns the corners and the alpha of each triangle of a mesh.
pub fn triangles(mesh: &Mesh) -> Vec<([[f32; 3]; 3], Option<TriangleAlpha>)> {
    let one = |t: &[u32; 3]| {
        let alpha = mesh.alpha.as_ref().map(|alpha| TriangleAlpha::new(alpha, *t));
        (t.map(|i| mesh.positions[i as usize]), alpha)
    };
    mesh.triangles.iter().map(one).collect()
}

/// Returns triangles as a map sees them that reads levels of textures (`AlphaTest::Coverage`, or `Hash` with `hashed`). Triangles keep their
/// alpha where the map reads level 0. Twin: alpha_level, alpha_at_level.
pub fn at_levels(
    view: &View,
    triangles: &[([[f32; 3]; 3], Option<TriangleAlpha>)],
    hashed: bool,
) -> Vec<([[f32; 3]; 3], Option<TriangleAlpha>)> {
    let mut known: Vec<(*const AlphaTexture, f32, Vec<AlphaLevel>)> = Vec::new();
    let of = |(number, (corners, alpha)): (usize, &([[f32; 3]; 3], Option<TriangleAlpha>))| {
        let Some(alpha) = alpha else { return (*corners, None) };
        let level = alpha.level(view, corners.map(Vec3::from));
        let (AlphaMode::Cut(cutoff), Some(texture), true) = (alpha.mode, &alpha.texture, level > 0) else {
            return (*corners, Some(alpha.clone()));
        };
        let place = known.iter().position(|(of, at, _)| *of == Arc::as_ptr(texture) && *at == cutoff);
        let place = place.unwrap_or_else(|| {
            known.push((Arc::as_ptr(texture), cutoff, alpha_levels(texture, cutoff)));
            known.len() - 1
        });
        let AlphaLevel { shares, threshold } = known[place].2[level as usize - 1].clone();
        let (mode, hashed) = (AlphaMode::Cut(threshold), hashed.then_some(number as u32));
        (*corners, Some(TriangleAlpha { mode, texture: Some(Arc::new(shares)), hashed, ..alpha.clone() }))
    };
    triangles.iter().enumerate().map(of).collect()
}

/// Twin: alpha_corner_texel.
fn map_place(view: &View, corner: Vec3) -> Vec2 {
    let offset = corner - Vec3::from(view.origin);
    let along = |axis: [f32; 3]| dot3(offset, Vec3::from(axis));
    let across = Vec2::new(along(view.right) * view.scale_x, along(view.up) * view.scale_y);
    let place = across * (0.5 * Vec2::new(view.width as f32, view.height as f32));
    match view.projection() {
        Projection::Parallel => place,
        Projection::Perspective => place * reciprocal(along(view.forward).max(view.near)),
    }
}

/// Twin: alpha_hash.
fn hash(bits: u32) -> u32 {
    let state = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = (state >> ((state >> 28) + 4) ^ state).wrapping_mul(277_803_737);
    word >> 22 ^ word
}

impl TriangleAlpha {
    /// Twin: alpha_level.
    fn level(&self, view: &View, corners: [Vec3; 3]) -> u32 {
        let Some(texture) = self.texture.as_ref().filter(|_| self.factors == [1.0; 3]) else { return 0 };
        let [a, b, c] = corners.map(|corner| map_place(view, corner));
        let (ab, ac, u, v) = (b - a, c - a, self.uvs[1] - self.uvs[0], self.uvs[2] - self.uvs[0]);
        let (in_map, in_texture) = ((ab.x * ac.y - ab.y * ac.x).abs(), (u.x * v.y - u.y * v.x).abs());
        let [width, height] = texture.size;
        let mut texels = in_texture * (width as f32 * height as f32);
        let (mut level, most) = (0, width.max(height).ilog2().saturating_sub(LAST_LEVEL));
        while texels > 2.0 * in_map && level < most {
            (texels, level) = (0.25 * texels, level + 1);
        }
        level
    }

    /// Returns the cutoff at a point of the triangle. Twin: alpha_stands.
    fn cutoff(&self, at: Vec2, cutoff: f32) -> f32 {
        let (Some(number), Some(texture)) = (self.hashed, &self.texture) else { return cutoff };
        let [a, b, c] = self.uvs;
        let uv = a + at.x * (b - a) + at.y * (c - a);
        let place = uv * (2.0 * Vec2::new(texture.size[0] as f32, texture.size[1] as f32));
        let cell = place.clamp(Vec2::splat(-1e9), Vec2::splat(1e9)).floor().as_ivec2();
        let bits = hash(number ^ hash(cell.x as u32 ^ hash(cell.y as u32)));
        ((bits >> 9) as f32 + 0.5) * (1.0 / 8_388_608.0)
    }

    fn new(alpha: &Alpha, triangle: [u32; 3]) -> Self {
        Self {
            mode: alpha.mode,
            uvs: triangle.map(|i| Vec2::from(alpha.uvs.get(i as usize).copied().unwrap_or_default())),
            factors: triangle.map(|i| alpha.factors.get(i as usize).copied().unwrap_or(1.0)),
            texture: alpha.texture.clone(),
            hashed: None,
        }
    }

    /// Returns alpha at a point of the triangle; `at` holds the weights of the second and third corners. Twin: alpha_value.
    pub fn value(&self, at: Vec2) -> f32 {
        let [a, b, c] = self.factors;
        let factor = a + at.x * (b - a) + at.y * (c - a);
        let Some(texture) = &self.texture else { return factor };
        let [a, b, c] = self.uvs;
        factor * alpha_texture(texture, a + at.x * (b - a) + at.y * (c - a))
    }

    /// Returns whether a point of the triangle blocks all light. Twin: alpha_blocks.
    pub fn blocks(&self, at: Vec2) -> bool {
        match self.mode {
            AlphaMode::Cut(cutoff) => self.value(at) >= self.cutoff(at, cutoff),
            AlphaMode::SeeThrough => false,
        }
    }

    /// Returns whether the triangle may block light in a cube. Twin: alpha_covers.
    pub fn covers(&self, corners: [Vec3; 3], low: Vec3, side: f32) -> bool {
        let AlphaMode::Cut(cutoff) = self.mode else { return false };
        let mut most = self.factors[0].max(self.factors[1].max(self.factors[2]));
        if let Some(texture) = &self.texture {
            let (across, down) = (self.uvs[1] - self.uvs[0], self.uvs[2] - self.uvs[0]);
            let plane = Plane::new(corners);
            let at = plane.weights(low + 0.5 * side);
            let uv = self.uvs[0] + at.x * across + at.y * down;
            let mut reach = Vec2::ZERO;
            for axis in 0..3 {
                let by = side * Vec2::new(plane.second[axis], plane.third[axis]);
                reach += 0.5 * (by.x * across + by.y * down).abs();
            }
            let least = self.uvs[0].min(self.uvs[1].min(self.uvs[2]));
            let greatest = self.uvs[0].max(self.uvs[1].max(self.uvs[2]));
            let (from, to) = ((uv - reach).max(least), (uv + reach).min(greatest));
            most *= most_texel(texture, from.min(to), from.max(to));
        }
        most >= cutoff * (1.0 - 1e-5)
    }
}

/// Twin: AlphaPlane.
#[derive(Clone, Copy)]
struct Plane {
    first: Vec3,
    second: Vec3,
    third: Vec3,
}

impl Plane {
    /// Twin: alpha_plane.
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        let normal = cross3(ab, ac);
        let inverse = reciprocal(dot3(normal, normal));
        Self { first: a, second: cross3(ac, normal) * inverse, third: cross3(normal, ab) * inverse }
    }

    /// Twin: alpha_weights.
    fn weights(&self, point: Vec3) -> Vec2 {
        let offset = point - self.first;
        Vec2::new(dot3(offset, self.second), dot3(offset, self.third))
    }
}

/// Twin: alpha_weights.
pub fn weights(corners: [Vec3; 3], point: Vec3) -> Vec2 {
    Plane::new(corners).weights(point)
}

/// Twin: alpha_place. Returns how far the place is from the first texel to the second, and both texels.
fn place(at: f32, size: i32, wrap: Wrap) -> (f32, [i32; 2]) {
    let whole = at.floor();
    let within = match wrap {
        Wrap::Repeat => at - whole,
        Wrap::Mirror if whole as i32 & 1 != 0 => 1.0 - (at - whole),
        Wrap::Mirror => at - whole,
        Wrap::Clamp => at.clamp(0.0, 1.0),
    };
    let place = within * size as f32 - 0.5;
    let first = place.floor() as i32;
    let texels = match wrap {
        Wrap::Repeat => [if first < 0 { size - 1 } else { first }, if first + 1 >= size { 0 } else { first + 1 }],
        _ => [first, first + 1],
    };
    (place - place.floor(), texels.map(|texel| texel.clamp(0, size - 1)))
}

fn texel(texture: &AlphaTexture, x: i32, y: i32) -> f32 {
    texture.texels[y as usize * texture.size[0] as usize + x as usize].into()
}

/// Twin: alpha_texture.
fn alpha_texture(texture: &AlphaTexture, uv: Vec2) -> f32 {
    let [width, height] = texture.size.map(|side| side as i32);
    let (x, columns) = place(uv.x, width, texture.wrap[0]);
    let (y, rows) = place(uv.y, height, texture.wrap[1]);
    let row = |row: i32| {
        let left = texel(texture, columns[0], row);
        left + x * (texel(texture, columns[1], row) - left)
    };
    let (above, below) = (row(rows[0]), row(rows[1]));
    (above + y * (below - above)) * (1.0 / 255.0)
}

/// Twin: wrapped.
fn wrapped(at: i32, size: i32, wrap: Wrap) -> i32 {
    match wrap {
        Wrap::Repeat => at.rem_euclid(size),
        Wrap::Mirror => {
            let within = at.rem_euclid(2 * size);
            within.min(2 * size - 1 - within)
        }
        Wrap::Clamp => at.clamp(0, size - 1),
    }
}

/// Twin: most_texel.
fn most_texel(texture: &AlphaTexture, low: Vec2, high: Vec2) -> f32 {
    let size = Vec2::new(texture.size[0] as f32, texture.size[1] as f32);
    let (from, to) = (low * size - (0.5 + TEXEL_MARGIN), high * size - (0.5 - TEXEL_MARGIN));
    if (to - from).max_element() > MOST_TEXELS as f32 || from.abs().max_element() > 1e6 {
        return 1.0;
    }
    let first = from.floor().as_ivec2();
    let count = to.floor().as_ivec2() + 2 - first;
    if count.x * count.y > MOST_TEXELS {
        return 1.0;
    }
    let at = |i: i32| {
        let [x, y] = [first.x + i % count.x, first.y + i / count.x];
        let at = IVec2::new(
            wrapped(x, texture.size[0] as i32, texture.wrap[0]),
            wrapped(y, texture.size[1] as i32, texture.wrap[1]),
        );
        texel(texture, at.x, at.y)
    };
    (0..count.x * count.y).map(at).fold(0.0, f32::max) * (1.0 / 255.0)
}
