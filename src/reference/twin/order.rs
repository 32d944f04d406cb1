//! CPU twin of glsl/maps/order: the order in which single-pass insertion draws casters, in f32.

use crate::scene::{Caster, View};
use glam::Vec3;

/// Maps a float to an integer so that integers sort like floats. Twin: float_order in glsl/maps/extents.glsl.
pub fn float_order(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 0x8000_0000 }
}

/// Inverts [`float_order`]. Twin: float_of_order.
pub fn float_of_order(order: u32) -> f32 {
    f32::from_bits(if order >> 31 == 1 { order & 0x7FFF_FFFF } else { !order })
}

/// Returns the z at which each caster starts in a map's view; for a strand, the z of its nearer end. Sorted by these keys, casters are
/// nearly in order of entry depth in each texel; no single order can match all texels exactly. Twin: glsl/maps/order/keys.comp.
pub fn keys(view: &View, casters: &[Caster]) -> Vec<f32> {
    let forward = Vec3::from(view.forward);
    let key = |caster: &Caster| {
        let start = (Vec3::from(caster.position) - Vec3::from(view.origin)).dot(forward);
        if caster.is_strand() { start.min(start + Vec3::from(caster.axis).dot(forward)) } else { start - caster.radius }
    };
    casters.iter().map(key).collect()
}

/// Returns the indices sorted by increasing key; equal keys keep their order. Twin: glsl/maps/order/count.comp, scan.comp and scatter.comp.
pub fn sort(keys: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by_key(|i| keys[*i as usize]);
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Increasing floats have increasing integers, and convert back to the same bits.
    #[test]
    fn floats_order_as_their_numbers() {
        let rising = [f32::NEG_INFINITY, -3e38, -1.0, -f32::MIN_POSITIVE, -0.0, 0.0, 1e-45, 1.0, 3e38, f32::INFINITY];
        assert!(rising.windows(2).all(|w| float_order(w[0]) < float_order(w[1])));
        assert!(rising.iter().all(|f| float_of_order(float_order(*f)).to_bits() == f.to_bits()));
    }
}
