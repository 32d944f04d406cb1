//! CPU twin of glsl/bins/tiles.glsl: where a particle stands in the order of a tile, in f32.

use crate::scene::{Particle, Projection, View};
use glam::{Vec2, Vec3};

/// Texels a side of a tile. Twin: TILE_TEXELS.
pub const TILE_TEXELS: u32 = 8;

/// The key that a tile's particles are sorted by, ties by particle index; none where the sphere misses all rays through
/// the tile's texel centres. `tile` counts tiles across and down. Twin: tile_distance, tile_missed, tile_key.
pub fn tile_key(view: &View, particle: &Particle, tile: [u32; 2]) -> Option<f32> {
    let offset = Vec3::from(particle.position) - Vec3::from(view.origin);
    let dot = |axis: [f32; 3]| offset.dot(Vec3::from(axis));
    let distance_square = match view.projection() {
        Projection::Perspective => 0.0,
        Projection::Parallel => {
            let scale = Vec2::new(view.scale_x, view.scale_y);
            let size = Vec2::new(view.width as f32, view.height as f32);
            let centre = Vec2::new(dot(view.right), dot(view.up));
            let first = Vec2::new((tile[0] * TILE_TEXELS) as f32, (tile[1] * TILE_TEXELS) as f32);
            let low = ((first + 0.5) / size * 2.0 - 1.0) / scale;
            let high = ((first + TILE_TEXELS as f32 - 0.5) / size * 2.0 - 1.0) / scale;
            let apart = (low - centre).max(centre - high).max(Vec2::ZERO) / particle.radius;
            apart.dot(apart)
        }
    };
    if distance_square > 1.0001 {
        return None;
    }
    let nearest = dot(view.forward) - particle.radius * (1.0 - distance_square).max(0.0).sqrt();
    Some(((nearest - view.near) / (view.far - view.near)).max(0.0))
}
