//! CPU twin of glsl/technique/stochastic/: where a texel's samples end, in f32.

use super::segment::{Segment, texel_segment};
use super::sums::{DARK, scale};
use crate::scene::{Caster, View};

/// Depth of a sample that no caster ends. Twin: NO_END.
pub const NO_END: u32 = u32::MAX;

/// Number of bisections per quantile. Twin: HALVINGS.
pub const HALVINGS: u32 = 16;

/// Relative distance to a threshold below which rounding may make a device decide differently.
const CLOSE: f32 = 2e-4;

fn hashed(bits: u32) -> u32 {
    let state = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Twin: stochastic_share.
fn share(bits: u32) -> f32 {
    ((bits >> 9) as f32 + 0.5) / 8_388_608.0
}

/// Twin: texel_key.
pub fn texel_key([x, y]: [u32; 2]) -> u32 {
    hashed(hashed(y) ^ x)
}

/// Twin: gradient_noise.
pub fn gradient_noise([x, y]: [u32; 2]) -> f32 {
    let bits = x.wrapping_mul(288_237_660).wrapping_add(y.wrapping_mul(25_070_368));
    let high = ((u64::from(bits) * 4_221_604_530) >> 32) as u32;
    share(bits.wrapping_mul(52).wrapping_add(high))
}

/// Twin: depth_bits.
fn depth_bits(depth: f32) -> u32 {
    depth.max(0.0).abs().to_bits()
}

/// The samples of a texel, and whether rounding may change them on a device.
pub struct Drawn {
    /// Depths at which the samples end, as float bits.
    pub samples: Vec<u32>,
    /// Whether a decision was so close that rounding may change it.
    pub close: bool,
}

impl Drawn {
    fn keep(&mut self, sample: u32, depth: f32) {
        let kept = &mut self.samples[sample as usize];
        *kept = (*kept).min(depth_bits(depth));
    }

    /// Twin: fly.
    fn fly(&mut self, key: u32, segment: &Segment) {
        let (count, mut i) = (self.samples.len() as u32, 0);
        while i < count {
            let flight = -share(hashed(key.wrapping_add(i))).ln();
            let ahead = (count - i) as f32 * segment.optical_depth;
            self.close |= (flight - ahead).abs() < CLOSE * ahead;
            if flight.is_nan() || flight >= ahead {
                return;
            }
            let flown = flight / segment.optical_depth;
            self.close |= (flown - flown.round()).abs() < CLOSE * flown && flown > 0.5;
            let passed = (flown as u32).min(count - 1 - i);
            let along = (flown - passed as f32).min(1.0);
            self.keep(i + passed, segment.entry + (segment.exit - segment.entry) * along);
            i += passed + 1;
        }
    }

    /// Twin: hash_alpha.
    fn hash_alpha(&mut self, noise: f32, segment: &Segment) {
        let count = self.samples.len() as u32;
        let taken = (1.0 - (-segment.optical_depth).exp()) * count as f32 - noise;
        self.close |= (taken - taken.round()).abs() < CLOSE * count as f32;
        for i in (0..count).take_while(|i| (*i as f32) < taken) {
            self.keep(i, 0.5 * (segment.entry + segment.exit));
        }
    }
}

/// Draws `count` samples of a texel, from casters with their indices. With `hash`, one noise value per texel decides for all casters;
/// otherwise each caster has its own random numbers. Twins: nearest.comp, draw.frag.
pub fn draw(view: &View, texel: [u32; 2], casters: &[(u32, Caster)], count: u32, hash: bool) -> Drawn {
    let mut drawn = Drawn { samples: vec![NO_END; count as usize], close: false };
    for (number, caster) in casters {
        let Some(segment) = texel_segment(view, texel, caster) else { continue };
        if hash {
            drawn.hash_alpha(gradient_noise(texel), &segment);
        } else {
            drawn.fly(hashed(texel_key(texel) ^ hashed(*number)), &segment);
        }
    }
    drawn
}

/// Optical depth of a texel's casters, in integer units.
pub struct Units {
    segments: Vec<Segment>,
    scale: f32,
    /// Total units of all segments.
    pub all: u32,
}

impl Units {
    /// Sums the casters' units; `bound` is [`super::sums::bound`] of the casters of the texel's tile.
    pub fn new(view: &View, texel: [u32; 2], casters: &[Caster], bound: u64) -> Self {
        let cut = |s: Segment| {
            let left = (DARK / s.optical_depth).min(1.0);
            let exit = s.entry + (s.exit - s.entry) * left;
            Segment { exit, optical_depth: s.optical_depth.min(DARK), ..s }
        };
        let segments: Vec<_> = casters.iter().filter_map(|c| texel_segment(view, texel, c)).map(cut).collect();
        let scale = scale(bound);
        let all = segments.iter().map(|s| (s.optical_depth * scale + 0.5) as u32).sum();
        Self { segments, scale, all }
    }

    /// Returns the units in front of a depth. Twin: shares_before.
    pub fn before(&self, depth: f32) -> u32 {
        let of = |s: &Segment| {
            let within = ((depth - s.entry) / (s.exit - s.entry).max(1e-30)).clamp(0.0, 1.0);
            let part = if depth >= s.exit { 1.0 } else { within };
            (part * (s.optical_depth * self.scale) + 0.5) as u32
        };
        self.segments.iter().map(of).sum()
    }

    /// Returns the depths of the first entry and the last exit; `None` if there are no segments.
    pub fn range(&self) -> Option<[f32; 2]> {
        let low = self.segments.iter().map(|s| s.entry).reduce(f32::min)?;
        let high = self.segments.iter().map(|s| s.exit).reduce(f32::max)?;
        Some([low, high])
    }

    /// Returns the error bound, in units, between a device's sums and the twin's: one unit per caster, plus a small fraction of the total.
    pub fn rounding(&self) -> u32 {
        self.segments.len() as u32 + (self.all as f32 * 2e-5) as u32
    }

    /// Returns the units of optical depth before the end of sample `i` of `count`.
    pub fn wanted(&self, texel: [u32; 2], i: u32, count: u32) -> u32 {
        let lost = ((i as f32 + share(texel_key(texel))) / count as f32).min(0.999_999_9);
        (-(1.0 - lost).ln() * self.scale) as u32
    }
}

/// Returns the depths of `count` samples of a texel, at evenly spaced quantiles of its transmittance, as bits. Twin: quantiles.comp.
pub fn quantiles(units: &Units, texel: [u32; 2], count: u32) -> Vec<u32> {
    let [low, high] = units.range().unwrap_or_default();
    let of = |i| {
        let wanted = units.wanted(texel, i, count);
        let (mut at, mut wide) = (low, high - low);
        for _ in 0..HALVINGS {
            wide *= 0.5;
            if units.before(at + wide) <= wanted {
                at += wide;
            }
        }
        if wanted < units.all { depth_bits(at) } else { NO_END }
    };
    (0..count).map(of).collect()
}

/// Twin: texel_transmittance.
pub fn transmittance(samples: &[u32], depth: f32) -> f32 {
    let before = depth.max(0.0).to_bits();
    samples.iter().filter(|end| **end > before).count() as f32 / samples.len() as f32
}

#[cfg(test)]
mod tests {
    use super::super::sums;
    use super::*;
    use crate::scene::tests::along_the_axis;
    use proptest::prelude::*;

    /// Returns the transmittance up to a depth, in f64.
    fn left(view: &View, casters: &[Caster], depth: f32) -> f64 {
        let of = |s: Segment| {
            let within = f64::from(depth - s.entry) / f64::from(s.exit - s.entry).max(1e-30);
            f64::from(s.optical_depth) * within.clamp(0.0, 1.0)
        };
        let taken: f64 = casters.iter().filter_map(|c| texel_segment(view, [0, 0], c)).map(of).sum();
        (-taken).exp()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        /// Over many texels, the mean is the truth and the mean squared error is T(1 − T)/N, both within five standard deviations.
        #[test]
        fn plain_samples_are_binomial(
            all in prop::collection::vec((-1.5..1.5f32, 0.05..0.5f32, 0.0..2.0f32), 1..8),
            depth in 0.1..0.9f32,
            count in prop::sample::select(vec![4u32, 16]),
        ) {
            const TEXELS: u32 = 4000;
            let (view, casters) = along_the_axis(&all);
            let truth = left(&view, &casters, depth);
            let numbered: Vec<_> = (0..).zip(casters).collect();
            // Renumbering the casters imitates other texels: the same segments get new random numbers.
            let errors: Vec<f64> = (0..TEXELS)
                .map(|t| {
                    let casters: Vec<_> = numbered.iter().map(|(i, c)| (i + 100 * t, *c)).collect();
                    f64::from(transmittance(&draw(&view, [0, 0], &casters, count, false).samples, depth)) - truth
                })
                .collect();
            let (n, variance) = (f64::from(TEXELS), truth * (1.0 - truth) / f64::from(count));
            let mean = errors.iter().sum::<f64>() / n;
            prop_assert!(mean.abs() <= 5.0 * (variance / n).sqrt() + 1e-6, "{mean} of {truth}");
            let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
            let found = squares.iter().sum::<f64>() / n;
            let spread = squares.iter().map(|s| (s - found).powi(2)).sum::<f64>() / n;
            prop_assert!((found - variance).abs() <= 5.0 * (spread / n).sqrt() + 1e-6, "{found}, not {variance}");
        }

        /// With quantiles the mean squared error is f (1 − f)/N², where N is the number of samples, T the transmittance and f the
        /// fractional part of N T. No texel's error reaches one sample.
        #[test]
        fn quantiles_are_off_by_less_than_one(
            all in prop::collection::vec((-1.5..1.5f32, 0.05..0.5f32, 0.0..2.0f32), 1..8),
            depth in 0.1..0.9f32,
            count in prop::sample::select(vec![4u32, 16]),
        ) {
            const TEXELS: u32 = 2000;
            let (view, casters) = along_the_axis(&all);
            let truth = left(&view, &casters, depth);
            let units = Units::new(&view, [0, 0], &casters, sums::bound(&casters, DARK));
            let of = |t: u32| {
                let samples = quantiles(&units, [t, 0], count);
                f64::from(transmittance(&samples, depth)) - truth
            };
            let errors: Vec<f64> = (0..TEXELS).map(of).collect();
            let n = f64::from(TEXELS);
            let f = (truth * f64::from(count)).fract();
            let variance = f * (1.0 - f) / f64::from(count).powi(2);
            let mean = errors.iter().sum::<f64>() / n;
            // Bisection finds a depth to 1/65,536 of the casters' range; this allows for the extinction over that distance.
            let densest: f32 = all.iter().map(|(_, _, density)| density).sum();
            let known = f64::from(densest) * 4.0 / 65_536.0 + 1e-4;
            prop_assert!(mean.abs() <= 5.0 * (variance / n).sqrt() + known, "{mean} of {truth}");
            let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
            let found = squares.iter().sum::<f64>() / n;
            let spread = squares.iter().map(|s| (s - found).powi(2)).sum::<f64>() / n;
            prop_assert!((found - variance).abs() <= 5.0 * (spread / n).sqrt() + known, "{found}, not {variance}");
            prop_assert!(errors.iter().all(|e| e.abs() < 1.0 / f64::from(count) + known));
        }

        /// Transmittance never rises, whichever way samples are drawn, and the order of casters makes no difference.
        #[test]
        fn invariants(all in prop::collection::vec((-1.5..1.5f32, 0.01..0.5f32, 0.0..300.0f32), 0..20), hash: bool) {
            let (view, casters) = along_the_axis(&all);
            let numbered: Vec<_> = (0..).zip(casters.iter().copied()).collect();
            let backwards: Vec<_> = numbered.iter().rev().copied().collect();
            let drawn = draw(&view, [0, 0], &numbered, 16, hash).samples;
            prop_assert_eq!(&drawn, &draw(&view, [0, 0], &backwards, 16, hash).samples);
            let units = Units::new(&view, [0, 0], &casters, sums::bound(&casters, DARK));
            for samples in [drawn, quantiles(&units, [0, 0], 16)] {
                prop_assert_eq!(transmittance(&samples, -1e-3), 1.0);
                let curve: Vec<f32> = (0..=64).map(|i| transmittance(&samples, i as f32 / 64.0)).collect();
                prop_assert!(curve.windows(2).all(|w| w[1] <= w[0]), "{curve:?}");
            }
        }
    }
}
