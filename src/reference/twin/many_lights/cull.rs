//! Twin of glsl/shading/many_lights/cull.comp, bit-exact since neither the twin nor the device divides or fuses operations.

use crate::scene::View;

/// Pixels per side of a tile.
pub const TILE: u32 = 16;

/// Twins: FAR_ROUNDING, NEAR_ROUNDING.
const FAR_ROUNDING: f32 = 2e-6;
const NEAR_ROUNDING: f32 = 1.0001;

/// A light's position and reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Position in world units.
    pub position: [f32; 3],
    /// 1 / radius², in 1 / world unit²; 0 for a light of unlimited reach.
    pub falloff: f32,
}

/// Returns, per tile, words with one bit per light that reaches the tile; tiles are in rows. `z` holds the depth of each pixel, 0 in the
/// sky.
pub fn cull(camera: &View, z: &[f32], lights: &[Reach]) -> Vec<u32> {
    let size = [camera.width, camera.height];
    let words = lights.len().div_ceil(32).max(1);
    let [across, down] = size.map(|s| s.div_ceil(TILE));
    let mut masks = Vec::new();
    for tile in (0..across * down).map(|i| [i % across, i / across]) {
        let low = tile.map(|t| t * TILE);
        let high = [0, 1].map(|i| (low[i] + TILE).min(size[i]));
        let pixels = (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| (y * size[0] + x) as usize));
        let seen = || pixels.clone().map(|i| z[i]).filter(|z| *z > 0.0);
        let (near, far) = (seen().fold(f32::INFINITY, f32::min), seen().fold(0.0, f32::max));
        let mut found = vec![0u32; words];
        for (i, light) in lights.iter().enumerate().filter(|_| near <= far) {
            found[i / 32] |= u32::from(reaches(camera, light, low, high, [near, far])) << (i % 32);
        }
        masks.extend(found);
    }
    masks
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn lies_outside(outside: f32, square: f32, falloff: f32) -> bool {
    outside > 0.0 && outside * outside * falloff > square * NEAR_ROUNDING
}

fn reaches(camera: &View, light: &Reach, low: [u32; 2], high: [u32; 2], [near, far]: [f32; 2]) -> bool {
    let offset = [0, 1, 2].map(|i| light.position[i] - camera.origin[i]);
    let [x, y, z] = [camera.right, camera.up, camera.forward].map(|axis| dot(offset, axis));
    let sum = |from: f32, of: [f32; 3]| of.iter().fold(from, |sum, c| sum + c.abs());
    let slack = (sum(sum(0.0, light.position), camera.origin) + far) * FAR_ROUNDING;
    let (before, behind) = (near - z - slack, z - far - slack);
    let mut outside = lies_outside(before, 1.0, light.falloff) || lies_outside(behind, 1.0, light.falloff);
    let axes = [(x, camera.scale_x, camera.width), (y, camera.scale_y, camera.height)];
    for (axis, (along, scale, wide)) in axes.into_iter().enumerate() {
        let wide = wide as f32;
        let scale = scale * wide;
        let at = along * scale;
        for (edge, sign) in [(low[axis], 1.0), (high[axis], -1.0)] {
            let slope = 2.0 * edge as f32 - wide;
            let off = sign * (slope * z - at);
            let square = scale * scale + slope * slope;
            outside |= lies_outside(off - slack * (scale.abs() + slope.abs()), square, light.falloff);
        }
    }
    !outside
}
