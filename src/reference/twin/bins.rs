//! CPU twin of glsl/maps/bins: the order of casters in a tile, and how far light reaches in a tile, in f32.

use super::segment::{ray, strand_along};
use crate::scene::{Caster, FARTHEST, Projection, View};
use glam::{IVec2, Vec2, Vec3};
use std::cmp::Ordering;

/// Texels per side of a tile. Twin: TILE_TEXELS.
pub const TILE_TEXELS: u32 = 8;

/// Orders casters by their values alone, so that the order does not depend on how they are listed. Twin: caster_after in
/// glsl/world/caster.glsl.
pub fn caster_order(a: &Caster, b: &Caster) -> Ordering {
    let all = |c: &Caster| [c.position.as_slice(), &[c.radius], &c.axis, &[c.density]].concat();
    all(a).partial_cmp(&all(b)).unwrap_or(Ordering::Equal)
}

/// Returns the squared distance of a caster from a tile shrunk by `inset` texels on each side, in units of the caster's radius. `tile`
/// counts tiles across and down. Twin: tile_distance.
pub fn tile_distance(view: &View, caster: &Caster, tile: [u32; 2], inset: f32) -> f32 {
    if view.projection() != Projection::Parallel {
        return 0.0;
    }
    let offset = Vec3::from(caster.position) - Vec3::from(view.origin);
    let scale = Vec2::new(view.scale_x, view.scale_y);
    let size = Vec2::new(view.width as f32, view.height as f32);
    let first = Vec2::new((tile[0] * TILE_TEXELS) as f32, (tile[1] * TILE_TEXELS) as f32);
    if caster.is_strand() {
        let (_, across) = tile_along(view, caster, tile);
        let circle = (TILE_TEXELS as f32 / (size * scale)).length();
        let apart = (across.length() - circle).max(0.0) / caster.radius;
        return apart * apart;
    }
    let centre = Vec2::new(offset.dot(Vec3::from(view.right)), offset.dot(Vec3::from(view.up)));
    let low = ((first + inset) / size * 2.0 - 1.0) / scale;
    let high = ((first + TILE_TEXELS as f32 - inset) / size * 2.0 - 1.0) / scale;
    let apart = (low - centre).max(centre - high).max(Vec2::ZERO) / caster.radius;
    apart.dot(apart)
}

/// Twin: tile_along.
fn tile_along(view: &View, strand: &Caster, tile: [u32; 2]) -> (f32, Vec3) {
    let first = Vec2::new((tile[0] * TILE_TEXELS) as f32, (tile[1] * TILE_TEXELS) as f32);
    let (start, axis, along) = strand_along(ray(view, first + 0.5 * TILE_TEXELS as f32), strand);
    let along = along.map_or(0.0, |along| along.clamp(0.0, 1.0));
    (along, start + along * axis)
}

/// Returns the key by which a tile's casters are sorted, with ties broken by [`caster_order`]; `None` if the caster misses all rays through
/// the tile's texel centres. `tile` counts tiles across and down. Twin: tile_missed, tile_key.
pub fn tile_key(view: &View, caster: &Caster, tile: [u32; 2]) -> Option<f32> {
    tile_key_within(view, caster, tile, 0.5)
}

/// Like [`tile_key`], for all rays through the tile shrunk by `inset` texels on each side.
pub fn tile_key_within(view: &View, caster: &Caster, tile: [u32; 2], inset: f32) -> Option<f32> {
    let forward = Vec3::from(view.forward);
    let centre = (Vec3::from(caster.position) - Vec3::from(view.origin)).dot(forward);
    let square = tile_distance(view, caster, tile, inset);
    let nearest = if caster.is_strand() {
        centre + tile_along(view, caster, tile).0 * Vec3::from(caster.axis).dot(forward)
    } else {
        centre - caster.radius * (1.0 - square).max(0.0).sqrt()
    };
    (square <= 1.0001).then(|| ((nearest - view.near) / (view.far - view.near)).max(0.0))
}

/// Returns how far light reaches in a tile: the farthest z at which a mesh stops it, over the tile and `reach` texels around it, or
/// [`FARTHEST`] if some of the light meets no mesh. `depths` is the opaque map, in rows of texels. Twin: glsl/maps/bins/horizon.comp.
pub fn horizon(volume: &View, opaque: &View, depths: &[f32], tile: [u32; 2], reach: u32) -> f32 {
    let in_opaque = |texel: Vec2| {
        let (origin, direction) = ray(volume, texel);
        let offset = origin + direction - Vec3::from(opaque.origin);
        let dot = |axis: [f32; 3]| offset.dot(Vec3::from(axis));
        let w = if opaque.projection() == Projection::Parallel { 1.0 } else { dot(opaque.forward) };
        let ndc = Vec2::new(dot(opaque.right) * opaque.scale_x, dot(opaque.up) * opaque.scale_y) / w;
        (ndc * 0.5 + 0.5) * Vec2::new(opaque.width as f32, opaque.height as f32)
    };
    let first = Vec2::new((tile[0] * TILE_TEXELS) as f32, (tile[1] * TILE_TEXELS) as f32);
    let (a, b) = (in_opaque(first - reach as f32), in_opaque(first + (TILE_TEXELS + reach) as f32));
    let size = IVec2::new(opaque.width as i32, opaque.height as i32);
    let texel = |at: Vec2| (at - 0.5).floor().clamp(Vec2::splat(-2.0), size.as_vec2()).as_ivec2();
    let (low, high) = (texel(a.min(b)) - 1, texel(a.max(b)) + 2);
    let mut far = if low.min_element() < 0 || high.cmpge(size).any() { 1.0f32 } else { 0.0 };
    if far < 1.0 {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                far = far.max(depths[(y * size.x + x) as usize]);
            }
        }
    }
    if far >= 1.0 {
        return FARTHEST;
    }
    let apart = (Vec3::from(opaque.origin) - Vec3::from(volume.origin)).dot(Vec3::from(volume.forward));
    opaque.near + far * (opaque.far - opaque.near) + apart
}
