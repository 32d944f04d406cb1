//! CPU twins of glsl/technique/beer_shadow_map/: where a texel's medium starts and ends, and its optical depth, in f32.

use super::segment::{Segment, texel_segment};
use super::sums::{DARK, scale};
use crate::scene::{Caster, View};

/// The content of a texel. Twin: glsl/technique/beer_shadow_map/texel.glsl.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// 1 − depth of the nearest entry; 0 if the texel is empty.
    pub one_minus_front: f32,
    /// Depth of the farthest exit; 0 if the texel is empty.
    pub back: f32,
    /// Optical depth of the whole ray.
    pub optical_depth: f32,
}

impl Texel {
    fn with(self, segment: Segment, optical_depth: f32) -> Self {
        Self {
            one_minus_front: self.one_minus_front.max(1.0 - segment.entry),
            back: self.back.max(segment.exit),
            optical_depth: self.optical_depth + optical_depth,
        }
    }

    /// Returns the light left at `depth`. Twin: beer_optical_depth.
    pub fn transmittance(&self, depth: f32) -> f32 {
        let front = 1.0 - self.one_minus_front;
        let share = if depth >= self.back {
            1.0
        } else if depth <= front {
            0.0
        } else {
            ((depth - front) / (self.back - front)).min(1.0)
        };
        (-self.optical_depth.min(65504.0) * share).exp()
    }
}

/// Builds a texel by drawing and blending its casters, before storage rounds it. Twin: blend.frag and its blending.
pub fn blend(view: &View, texel: [u32; 2], casters: &[Caster]) -> Texel {
    let segments = casters.iter().filter_map(|c| texel_segment(view, texel, c)).filter(|s| s.optical_depth > 0.0);
    segments.fold(Texel::default(), |texel, s| texel.with(s, s.optical_depth))
}

/// Builds a texel from its tile's casters. Optical depths are summed as integers; `bound` is [`super::sums::bound`] of the casters of the
/// texel's tile. Twin: collect.comp.
pub fn collect(view: &View, texel: [u32; 2], casters: &[Caster], bound: u64) -> Texel {
    let (scale, mut units, mut kept) = (scale(bound), 0u32, Texel::default());
    for segment in casters.iter().filter_map(|c| texel_segment(view, texel, c)).filter(|s| s.optical_depth > 0.0) {
        let share = (DARK / segment.optical_depth).min(1.0);
        let exit = segment.entry + (segment.exit - segment.entry) * share;
        units += (segment.optical_depth.min(DARK) * scale + 0.5) as u32;
        kept = kept.with(Segment { exit, ..segment }, 0.0);
    }
    Texel { optical_depth: units as f32 / scale, ..kept }
}

/// Like [`collect`], but the medium starts at the mean depth of the casters, weighted by the light that they absorb. Twin: WEIGHTED_FRONT
/// of collect.comp.
pub fn weighted(view: &View, texel: [u32; 2], casters: &[Caster], bound: u64) -> Texel {
    let plain = collect(view, texel, casters, bound);
    let (front, scale) = (1.0 - plain.one_minus_front, scale(bound));
    let extinction = plain.optical_depth.min(DARK) / (plain.back - front).max(1e-9);
    let (mut weights, mut places) = (0u32, 0u32);
    for segment in casters.iter().filter_map(|c| texel_segment(view, texel, c)).filter(|s| s.optical_depth > 0.0) {
        let share = (DARK / segment.optical_depth).min(1.0);
        // max(…, 0): in a thin medium a position may be rounded to just before the front, where its weight would be huge.
        let place = (segment.entry + 0.5 * (segment.exit - segment.entry) * share - front).max(0.0);
        let weight = segment.optical_depth.min(DARK) * (-extinction * place).exp() * scale;
        weights += (weight + 0.5) as u32;
        places += (weight * place + 0.5) as u32;
    }
    if weights == 0 {
        return plain;
    }
    let deeper = places as f32 / weights as f32;
    Texel { one_minus_front: plain.one_minus_front - deeper, back: plain.back + deeper, ..plain }
}

/// Optical depth stored where no light is left, in coarser levels of detail.
const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// Returns the mean transmittance along a uniform medium of optical depth `t`. Twin: even_mean.
fn even_mean(t: f32) -> f32 {
    if t < 0.01 { 1.0 - t * (0.5 - t / 6.0) } else { (1.0 - (-t).exp()) / t }
}

/// Builds a texel of a coarser level of detail from four texels. Behind the farthest back of the four, it transmits the mean of their
/// light. Between their nearest front and that back, the area under its transmittance curve is the mean of their areas. Texels past the
/// map's edge count as empty. Twin: levels.comp.
pub fn merged(below: [Texel; 4]) -> Texel {
    let below = below.map(|t| Texel { optical_depth: t.optical_depth.min(65504.0), ..t });
    let casts = below.iter().filter(|texel| texel.optical_depth > 0.0);
    let nearest = casts.clone().map(|texel| 1.0 - texel.one_minus_front).fold(f32::INFINITY, f32::min);
    let farthest = casts.map(|texel| texel.back).fold(f32::NEG_INFINITY, f32::max);
    let (mut tail, mut area) = (0.0, 0.0);
    for texel in &below {
        let is_there = texel.optical_depth > 0.0;
        let front = if is_there { 1.0 - texel.one_minus_front } else { farthest };
        let back = if is_there { texel.back.max(front) } else { farthest };
        let left = (-texel.optical_depth).exp();
        tail += 0.25 * left;
        area += 0.25 * ((front - nearest) + (back - front) * even_mean(texel.optical_depth) + (farthest - back) * left);
    }
    if nearest > farthest || tail >= 1.0 {
        return Texel::default();
    }
    let optical_depth = (-tail.max(1e-35).ln()).min(MAX_OPTICAL_DEPTH);
    let mean = even_mean(optical_depth);
    if mean > 0.9999 {
        return Texel { one_minus_front: 1.0 - nearest, back: farthest, optical_depth };
    }
    let front = (area + nearest - farthest * mean) / (1.0 - mean);
    let back = if front < nearest { (area + nearest * mean - farthest * tail) / (mean - tail) } else { farthest };
    Texel { one_minus_front: 1.0 - front.clamp(nearest, farthest), back: back.clamp(nearest, farthest), optical_depth }
}

#[cfg(test)]
mod tests {
    use super::super::sums;
    use super::*;
    use crate::scene::tests::along_the_axis;
    use proptest::prelude::*;

    proptest! {
        /// The merged texel's transmittance is the mean of the four below: behind all casters, and averaged over the depths from the
        /// nearest front to the farthest back.
        #[test]
        fn levels_are_means(all in prop::collection::vec((0.0..0.9f32, 0.0..0.5f32, prop_oneof![Just(0.0f32), 0.01..4.0f32, Just(200.0)]), 4)) {
            let texel = |i: usize| {
                let (front, length, optical_depth) = all[i];
                Texel { one_minus_front: 1.0 - front, back: front + length, optical_depth }
            };
            let below = [0, 1, 2, 3].map(texel);
            let casts = below.iter().filter(|t| t.optical_depth > 0.0);
            let nearest = casts.clone().map(|t| 1.0 - t.one_minus_front).fold(f32::INFINITY, f32::min);
            let farthest = casts.map(|t| t.back).fold(f32::NEG_INFINITY, f32::max);
            let merged = merged(below);
            let mean = |depth: f32| below.iter().map(|t| f64::from(t.transmittance(depth))).sum::<f64>() / 4.0;
            prop_assert!((f64::from(merged.transmittance(2.0)) - mean(2.0)).abs() < 1e-5, "{merged:?}");
            if nearest < farthest {
                const STEPS: u16 = 20_000;
                let of = |through: &dyn Fn(f32) -> f64| {
                    let at = |i: u16| nearest + (farthest - nearest) * (f32::from(i) + 0.5) / f32::from(STEPS);
                    (0..STEPS).map(|i| through(at(i))).sum::<f64>() / f64::from(STEPS)
                };
                let (found, expected) = (of(&|depth| merged.transmittance(depth).into()), of(&mean));
                prop_assert!((found - expected).abs() < 1e-3, "{found}, not {expected}: {merged:?} of {below:?}");
            }
        }

        /// Transmittance stays in [0, 1], never rises, is 1 in front of all casters, and behind them is the product of their
        /// transmittances.
        #[test]
        fn invariants(all in prop::collection::vec((-1.5..1.5f32, 0.01..0.5f32, 0.0..3.0f32), 0..40)) {
            let (view, casters) = along_the_axis(&all);
            let bound = sums::bound(&casters, DARK);
            let depths = casters.iter().filter_map(|c| texel_segment(&view, [0, 0], c)).map(|s| f64::from(s.optical_depth));
            let product = (-depths.sum::<f64>()).exp();
            for texel in [blend(&view, [0, 0], &casters), collect(&view, [0, 0], &casters, bound)] {
                let mut last = texel.transmittance(-1e-3);
                prop_assert_eq!(last, 1.0);
                for i in 0..=64 {
                    let t = texel.transmittance(i as f32 / 64.0);
                    prop_assert!((0.0..=last).contains(&t), "{t} after {last}");
                    last = t;
                }
                prop_assert!((f64::from(last) - product).abs() < 1e-4, "{last}, not {product}");
            }
            // A weighted front lies behind the nearest entry and in front of the farthest exit, and the extinction stays the same.
            let (first, weighted) = (collect(&view, [0, 0], &casters, bound), weighted(&view, [0, 0], &casters, bound));
            let [deeper, farther] = [first.one_minus_front - weighted.one_minus_front, weighted.back - first.back];
            prop_assert!(deeper >= 0.0 && (deeper - farther).abs() < 1e-5, "{first:?}, {weighted:?}");
            let lies_within = first.optical_depth == 0.0 || 1.0 - weighted.one_minus_front <= first.back + 1e-4;
            prop_assert!(lies_within, "{first:?}, {weighted:?}");
        }

        /// The weighted front of a single sphere is at the sphere's centre.
        #[test]
        fn one_sphere_is_weighed_at_its_middle(z in -1.0..1.0f32, radius in 0.1..0.5f32, density in 0.01..5.0f32) {
            let (view, casters) = along_the_axis(&[(z, radius, density)]);
            let segment = texel_segment(&view, [0, 0], &casters[0]).expect("on the axis");
            let front = 1.0 - weighted(&view, [0, 0], &casters, sums::bound(&casters, DARK)).one_minus_front;
            prop_assert!((front - 0.5 * (segment.entry + segment.exit)).abs() < 1e-3, "{front} of {segment:?}");
        }

        #[test]
        fn one_sphere_is_exact(z in -1.0..1.0f32, radius in 0.1..0.5f32, density in 0.01..5.0f32, depth in 0.0..1.0f32) {
            let (view, casters) = along_the_axis(&[(z, radius, density)]);
            let segment = texel_segment(&view, [0, 0], &casters[0]).expect("on the axis");
            let share = ((depth - segment.entry) / (segment.exit - segment.entry)).clamp(0.0, 1.0);
            let expected = (-segment.optical_depth * share).exp();
            let found = blend(&view, [0, 0], &casters).transmittance(depth);
            prop_assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
        }
    }
}
