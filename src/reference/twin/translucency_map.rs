//! CPU twins of glsl/technique/translucency_map/: transmittance of all casters on a texel's ray, in f32.

use super::segment::texel_segment;
use super::sums::{DARK, scale};
use crate::scene::{Caster, View};

/// Returns the product of the casters' transmittances, without the rounding of storage after each caster. Twin: multiply.frag and its
/// blending.
pub fn multiply(view: &View, texel: [u32; 2], casters: &[Caster]) -> f32 {
    casters.iter().filter_map(|c| texel_segment(view, texel, c)).map(|s| (-s.optical_depth).exp()).product()
}

/// Returns the same product, computed from optical depths summed as integers; `bound` is [`super::sums::bound`] of the casters of the
/// texel's tile. Twin: sum.comp.
pub fn sum(view: &View, texel: [u32; 2], casters: &[Caster], bound: u64) -> f32 {
    let scale = scale(bound);
    let segments = casters.iter().filter_map(|c| texel_segment(view, texel, c));
    let units: u32 = segments.map(|s| (s.optical_depth.min(DARK) * scale + 0.5) as u32).sum();
    (-(units as f32 / scale)).exp()
}

/// Returns a texel of a coarser level of detail: the mean of the four below. Texels past the map's edge are `None` and count as unshadowed.
/// Twin:
/// levels.comp.
pub fn merged(below: [Option<f32>; 4]) -> f32 {
    below.iter().fold(0.0, |sum, texel| sum + 0.25 * texel.unwrap_or(1.0))
}

#[cfg(test)]
mod tests {
    use super::super::sums;
    use super::*;
    use crate::scene::tests::along_the_axis;
    use proptest::prelude::*;

    proptest! {
        /// Both functions give the product over all casters, in any order.
        #[test]
        fn both_are_the_product(all in prop::collection::vec((-1.5..1.5f32, 0.01..0.5f32, 0.0..3.0f32), 0..40)) {
            let (view, casters) = along_the_axis(&all);
            let depths = casters.iter().filter_map(|c| texel_segment(&view, [0, 0], c)).map(|s| f64::from(s.optical_depth));
            let product = (-depths.sum::<f64>()).exp();
            let bound = sums::bound(&casters, DARK);
            let summed = sum(&view, [0, 0], &casters, bound);
            prop_assert!((f64::from(multiply(&view, [0, 0], &casters)) - product).abs() < 1e-5);
            prop_assert!((f64::from(summed) - product).abs() < 1e-4, "{summed}, not {product}");
            let backwards: Vec<_> = casters.iter().rev().copied().collect();
            prop_assert_eq!(summed, sum(&view, [0, 0], &backwards, bound));
        }
    }
}
