//! CPU twin of glsl/technique/ray_query/: a box around each caster, and whether a ray ends there by chance, in f32.

use super::splat::strand_axis;
use crate::scene::Caster;
use glam::Vec3;

/// Twin: BOX_MARGIN.
const MARGIN: f32 = 1e-5;

/// Returns the low and high corners of the box around a caster; `None` for a caster of radius 0, which casts no shadow.
pub fn boxed(caster: &Caster) -> Option<[[f32; 3]; 2]> {
    let (start, end) = (Vec3::from(caster.position), Vec3::from(caster.position) + strand_axis(caster));
    let margin = caster.radius + MARGIN * (caster.radius + start.abs().max(end.abs()));
    let of = [start.min(end) - margin, start.max(end) + margin];
    (caster.radius > 0.0).then(|| of.map(|corner| corner.to_array()))
}

fn hashed(bits: u32) -> u32 {
    let state = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Returns the seed of a point's random numbers for look-ups without dithering. Twin: hit_seed.
pub fn hit_seed(light: u32, position: [f32; 3]) -> u32 {
    let [x, y, z] = position.map(f32::to_bits);
    let dither = (-1f32).to_bits();
    let seed = hashed(x ^ hashed(y ^ hashed(z ^ hashed(light))));
    hashed(seed ^ dither ^ hashed(dither ^ hashed(dither)))
}

/// Returns a number between 0 and 1. A ray passes through `caster` if the number is below the caster's transmittance. Twin: hit_ends.
pub fn hit_share(seed: u32, caster: u32) -> f32 {
    ((hashed(seed ^ hashed(caster)) >> 9) as f32 + 0.5) / 8_388_608.0
}
