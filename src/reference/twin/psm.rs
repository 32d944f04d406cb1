//! CPU twins of glsl/technique/psm/: transmittance behind each slice of a texel's ray, in f32. Source: NVIDIA's talk at GDC 2013, "Particle
//! Shadow Mapping", steps 2 to 4; the split, sums of optical depths and [`fused`] are ours.

use super::segment::texel_segment;
use super::splat::strand_axis;
use super::sums::{self, DARK};
use crate::scene::{Caster, View};
use glam::Vec3;

/// How a ray is divided into slices.
#[derive(Clone, Copy, Debug)]
pub struct Slices {
    /// Number of slices.
    pub count: u32,
    /// Whether a caster's optical depth is split between the two slices around its centre.
    pub split: bool,
}

/// The slices that receive a caster's optical depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The first slice.
    pub slice: usize,
    /// Share of the optical depth that goes to the next slice.
    pub share: f32,
}

/// Returns the depth of a caster's centre, in slices from the first. Twin: the first half of caster_place.
pub fn depth_in_slices(view: &View, caster: &Caster, count: u32) -> f32 {
    let middle = Vec3::from(caster.position) + 0.5 * strand_axis(caster) - Vec3::from(view.origin);
    (middle.dot(Vec3::from(view.forward)) - view.near) / (view.far - view.near) * count as f32
}

/// Twin: caster_place in glsl/technique/psm/place.glsl.
pub fn place(view: &View, caster: &Caster, slices: Slices) -> Place {
    let at = depth_in_slices(view, caster, slices.count) - if slices.split { 0.5 } else { 0.0 };
    let at = at.clamp(0.0, (slices.count - 1) as f32);
    Place { slice: at as usize, share: if slices.split { at.fract() } else { 0.0 } }
}

/// Returns the optical depth in each slice of a texel's ray. Twin: voxelize.frag and its blending. Source: step 2, "Voxelize
/// Transmittances".
pub fn voxelize(view: &View, texel: [u32; 2], casters: &[Caster], slices: Slices) -> Vec<f32> {
    let mut local = vec![0.0; slices.count as usize];
    for caster in casters {
        let Some(segment) = texel_segment(view, texel, caster) else { continue };
        let place = place(view, caster, slices);
        local[place.slice] += segment.optical_depth * (1.0 - place.share);
        if place.share > 0.0 {
            local[place.slice + 1] += segment.optical_depth * place.share;
        }
    }
    local
}

/// Returns the transmittance behind each slice, from each slice's own transmittance. Twin: propagate.comp. Source: step 3, "Propagate
/// Transmittances".
pub fn propagate(leaves: &[f32]) -> Vec<f32> {
    let product = |before: &mut f32, leaves: &f32| {
        *before *= leaves;
        Some(*before)
    };
    leaves.iter().scan(1.0, product).collect()
}

/// Returns the transmittance behind each slice, from each slice's own optical depth. Twin: propagate.comp, ADDITIVE.
pub fn propagate_depths(local: &[f32]) -> Vec<f32> {
    let sum = |before: &mut f32, local: &f32| {
        *before += local;
        Some((-*before).exp())
    };
    local.iter().scan(0.0, sum).collect()
}

/// Returns the smallest number of casters for which a tile's unit depends on their optical depths. For fewer, it depends only on their
/// number. Twin: MANY.
pub fn many(split: bool) -> usize {
    if split { 128 } else { 256 }
}

/// Returns the number of units per optical depth of 1 in the sums of [`fused`], for the casters of a tile. Twin: part_scale.
pub fn scale(casters: &[Caster], split: bool) -> f32 {
    if casters.len() < many(split) {
        let bits = 27 - i32::from(split) - casters.len().max(1).ilog2() as i32;
        return (bits.min(22) as f32).exp2();
    }
    sums::scale(sums::bound(casters, if split { 2.0 * DARK } else { DARK }))
}

/// Returns the transmittance behind each slice, from integer sums; `scale` is [`scale`] of the casters of the texel's tile.
/// Twin: fused.comp.
pub fn fused(view: &View, texel: [u32; 2], casters: &[Caster], slices: Slices, scale: f32) -> Vec<f32> {
    let mut sums = vec![0u32; slices.count as usize];
    for caster in casters {
        let Some(segment) = texel_segment(view, texel, caster) else { continue };
        let place = place(view, caster, slices);
        let units = |share: f32| ((segment.optical_depth * share).min(DARK) * scale + 0.5) as u32;
        sums[place.slice] += units(1.0 - place.share);
        if place.share > 0.0 {
            sums[place.slice + 1] += units(place.share);
        }
    }
    let run = |before: &mut u32, sum: &u32| {
        *before += sum;
        Some((-(*before as f32 / scale)).exp())
    };
    sums.iter().scan(0, run).collect()
}

/// Returns how much light reaches `depth`, from 0 to 1 in the light's range, on a ray with transmittance `behind` behind its slices.
/// Twin: texel_transmittance in glsl/technique/psm/visibility.glsl. Source: step 4, "Sample from PSM".
pub fn look_up(behind: &[f32], depth: f32) -> f32 {
    let at = depth.clamp(0.0, 1.0) * behind.len() as f32;
    let face = (at as usize).min(behind.len() - 1);
    let near = if face == 0 { 1.0 } else { behind[face - 1] };
    near + (behind[face] - near) * (at - face as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::along_the_axis;
    use proptest::prelude::*;

    fn casters() -> impl Strategy<Value = Vec<Caster>> {
        prop::collection::vec((-1.5..1.5f32, 0.01..0.5f32, prop_oneof![0.0..3.0f32, Just(0.0), Just(1e6)]), 0..40)
            .prop_map(|all| along_the_axis(&all).1)
    }

    proptest! {
        /// Sums over up to 255 casters, each as dark as possible, fit into 32 bits. For fewer than MANY, rounding errors add up to at most
        /// 2⁻¹³, as fused.comp states.
        #[test]
        fn the_unit_suits_few_casters(count in 1usize..256, split: bool) {
            let casters = vec![along_the_axis(&[(0.0, 1.0, 1e6)]).1[0]; count];
            let (unit, shares) = (1.0 / f64::from(scale(&casters, split)), 1.0 + f64::from(u8::from(split)));
            prop_assert!(count as f64 * shares * f64::from(DARK) / unit < 2f64.powi(32));
            prop_assert!(count >= many(split) || count as f64 * shares * 0.5 * unit <= 2f64.powi(-13));
        }

        /// Three ways of computing a ray agree: adding optical depths, multiplying transmittances, and the fused pass. Transmittance never
        /// rises, and ends at the product over all casters.
        #[test]
        fn one_ray_three_ways(casters in casters(), count in prop::sample::select(vec![4u32, 8, 64, 256]), split: bool) {
            let (view, slices) = (along_the_axis(&[]).0, Slices { count, split });
            let local = voxelize(&view, [0, 0], &casters, slices);
            let added = propagate_depths(&local);
            let multiplied = propagate(&local.iter().map(|d| (-d).exp()).collect::<Vec<_>>());
            let whole = fused(&view, [0, 0], &casters, slices, scale(&casters, split));
            let mut last = 1.0;
            for i in 0..count as usize {
                prop_assert!((added[i] - multiplied[i]).abs() < 1e-5 && (added[i] - whole[i]).abs() < 1e-4);
                prop_assert!(whole[i] <= last && whole[i] >= 0.0);
                last = whole[i];
            }
            let segments = casters.iter().filter_map(|c| texel_segment(&view, [0, 0], c));
            let product = (-segments.map(|s| f64::from(s.optical_depth)).sum::<f64>()).exp();
            prop_assert!((f64::from(last) - product).abs() < 1e-4, "{last}, not {product}");
            let backwards: Vec<_> = casters.iter().rev().copied().collect();
            prop_assert_eq!(whole, fused(&view, [0, 0], &backwards, slices, scale(&casters, split)));
        }
    }
}
