//! CPU twin of glsl/technique/layers/: optical depths up to the ends of a texel's layers, in f32.

use super::texel_sums::{self, Range, place};
use crate::scene::{Caster, View};

/// Returns where layer k of `count` ends. Twin: layer_end.
pub fn end(range: Range, count: usize, k: usize) -> f32 {
    let of = count as f32;
    if range == Range::Front { (k * (k + 1)) as f32 / (of * (of + 1.0)) } else { k as f32 / of }
}

/// Returns what a segment between two positions adds to each layer's sum. Twin: segment_parts.
pub fn parts<const N: usize>(range: Range, [from, to]: [f32; 2], optical_depth: f32) -> [f32; N] {
    let steepness = if to > from { 1.0 / (to - from) } else { 0.0 };
    std::array::from_fn(|k| match end(range, N, k + 1) {
        end if end >= to => optical_depth,
        end => optical_depth * ((end - from) * steepness).clamp(0.0, 1.0),
    })
}

/// The content of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel<const N: usize> {
    /// Kind of range that the layers divide.
    pub of: Range,
    /// Depths at which the range starts and ends.
    pub range: [f32; 2],
    /// Optical depth from the light to the end of each layer.
    pub optical_depths: [f32; N],
}

impl<const N: usize> Texel<N> {
    /// Builds a texel from its tile's casters; the last argument is [`super::sums::bound`] of these casters. Twin: binned.comp.
    pub fn binned(of: Range, texel: (&View, [u32; 2], &[Caster], u64)) -> Self {
        let (range, optical_depths) = texel_sums::binned(texel, of, |places, taken| parts(of, places, taken));
        Self { of, range, optical_depths }
    }

    /// Builds a texel whose casters are drawn and blended. Twin: raster.frag.
    pub fn drawn(of: Range, texel: (&View, [u32; 2], &[Caster])) -> Self {
        let (range, optical_depths) = texel_sums::drawn(texel, of, |places, taken| parts(of, places, taken));
        Self { of, range, optical_depths }
    }

    /// Averages four texels for a coarser level of detail; the range comes from the texels that have casters. Twin: levels.comp.
    pub fn merged(of: Range, below: [Option<Self>; 4]) -> Self {
        let casts = below.iter().flatten().filter(|texel| texel.optical_depths[N - 1] > 0.0);
        let front = casts.clone().map(|texel| texel.range[0]).fold(f32::INFINITY, f32::min);
        let back = casts.map(|texel| texel.range[1]).fold(f32::NEG_INFINITY, f32::max);
        let is_empty = front > back;
        let range = match of {
            Range::Scene => [0.0, 1.0],
            Range::Front => [if is_empty { 0.0 } else { front }, 1.0],
            Range::Texel if is_empty => [0.0, 0.0],
            Range::Texel => [front, back],
        };
        let mean = |k: usize| {
            let along = end(of, N, k + 1);
            let depth = range[0] * (1.0 - along) + range[1] * along;
            let one = |texel: &Option<Self>| texel.as_ref().map_or(1.0, |texel| texel.transmittance(depth));
            let mean = below.iter().fold(0.0, |sum, texel| sum + 0.25 * one(texel));
            if mean < 1.0 { -mean.max(1e-35).ln() } else { 0.0 }
        };
        Self { of, range, optical_depths: std::array::from_fn(mean) }
    }

    /// Returns the texel as quantized by `storage`.
    pub fn kept(self, storage: impl Fn(f32) -> f32) -> Self {
        Self { optical_depths: self.optical_depths.map(storage), ..self }
    }

    /// Twin: texel_transmittance in visibility.glsl.
    pub fn transmittance(&self, depth: f32) -> f32 {
        let place = place(self.range, depth);
        let layer = (0..N - 1).find(|k| end(self.of, N, k + 1) > place).unwrap_or(N - 1);
        let (begin, end) = (end(self.of, N, layer), end(self.of, N, layer + 1));
        let along = ((place - begin) / (end - begin)).clamp(0.0, 1.0);
        let before = layer.checked_sub(1).map_or(0.0, |k| self.optical_depths[k]);
        (-(before * (1.0 - along) + self.optical_depths[layer] * along)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::super::segment::texel_segment;
    use super::super::sums::{DARK, bound};
    use super::*;
    use crate::scene::tests::along_the_axis;
    use proptest::prelude::*;

    const RANGES: [Range; 3] = [Range::Scene, Range::Front, Range::Texel];

    /// Quantization by each storage format: 32-bit floats, half floats, fixed point.
    const STORAGES: [fn(f32) -> f32; 3] = [
        |sum| sum,
        |sum| half::f16::from_f32(sum.min(65504.0)).to_f32(),
        |sum| ((sum / DARK).min(1.0) * 65535.0).round() / 65535.0 * DARK,
    ];

    fn casters() -> impl Strategy<Value = Vec<(f32, f32, f32)>> {
        // Densities of empty casters, of smoke and of opaque casters.
        let density = prop_oneof![Just(0.0f32), 0.0..3.0f32, Just(1e6f32)];
        prop::collection::vec((-1.5..1.5f32, 0.01..0.5f32, density), 0..40)
    }

    /// Returns the exact optical depth up to a depth, in f64, without layers.
    fn exact(view: &View, casters: &[Caster], depth: f64) -> f64 {
        let of = |c: &Caster| {
            let s = texel_segment(view, [0, 0], c)?;
            let (entry, exit) = (f64::from(s.entry), f64::from(s.exit));
            let share = if depth >= exit { 1.0 } else { ((depth - entry) / (exit - entry)).max(0.0) };
            Some(f64::from(s.optical_depth) * share)
        };
        casters.iter().filter_map(of).sum()
    }

    proptest! {
        /// Transmittance stays in [0, 1], never rises, is 1 in front of all casters, and behind them is the product of their
        /// transmittances. Any order of casters gives the same bits.
        #[test]
        fn invariants(all in casters()) {
            let (view, casters) = along_the_axis(&all);
            let bound = bound(&casters, DARK);
            let product = (-exact(&view, &casters, 2.0)).exp();
            let backwards: Vec<_> = casters.iter().rev().copied().collect();
            for (range, storage) in RANGES.into_iter().flat_map(|r| STORAGES.map(|s| (r, s))) {
                let texel = Texel::<8>::binned(range, (&view, [0, 0], &casters, bound));
                prop_assert_eq!(texel, Texel::binned(range, (&view, [0, 0], &backwards, bound)));
                let texel = texel.kept(storage);
                let mut last = texel.transmittance(-1e-3);
                prop_assert_eq!(last, 1.0);
                for i in 0..=64 {
                    let t = texel.transmittance(i as f32 / 64.0);
                    // Interpolation between two sums rounds.
                    prop_assert!((0.0..=last + 1e-6).contains(&t), "{range:?}: {t} after {last}");
                    last = t;
                }
                prop_assert!((f64::from(last) - product).abs() < 3e-4, "{range:?}: {last}, not {product}");
            }
        }

        /// If the range covers exactly one sphere, its layers are exact everywhere.
        #[test]
        fn one_sphere_is_exact(z in -1.0..1.0f32, radius in 0.1..0.5f32, density in 0.01..5.0f32, depth in 0.0..1.0f32) {
            let (view, casters) = along_the_axis(&[(z, radius, density)]);
            let texel = Texel::<4>::binned(Range::Texel, (&view, [0, 0], &casters, bound(&casters, DARK)));
            let (found, expected) = (texel.transmittance(depth), (-exact(&view, &casters, depth.into())).exp());
            prop_assert!((f64::from(found) - expected).abs() < 1e-5, "{found}, not {expected}");
        }

        /// At the ends of layers, the sums are exact for any casters.
        #[test]
        fn ends_are_exact(all in casters()) {
            let (view, casters) = along_the_axis(&all);
            for range in RANGES {
                let texel = Texel::<8>::binned(range, (&view, [0, 0], &casters, bound(&casters, DARK)));
                for k in 1..=8 {
                    let depth = texel.range[0] + end(range, 8, k) * (texel.range[1] - texel.range[0]);
                    let expected = (-exact(&view, &casters, depth.into())).exp();
                    let found = (-texel.optical_depths[k - 1]).exp();
                    // Near an opaque caster, the rounding of a depth decides between lit and dark.
                    let near = [-1e-6, 1e-6].map(|off| (-exact(&view, &casters, f64::from(depth) + off)).exp());
                    let tolerance = 1e-5 + (near[0] - near[1]).abs();
                    prop_assert!((f64::from(found) - expected).abs() < tolerance, "{range:?} {k}: {found}, not {expected}");
                }
            }
        }
    }

    /// Spheres behind one another form uniform slabs. With one layer per slab, of the same extent, the curve is exact at all depths.
    #[test]
    fn even_slabs_are_exact() {
        let slabs: Vec<_> = (0..4).map(|i| (0.75 - 0.5 * i as f32, 0.25, 0.5 + i as f32)).collect();
        let (view, casters) = along_the_axis(&slabs);
        let texel = Texel::<4>::binned(Range::Texel, (&view, [0, 0], &casters, bound(&casters, DARK)));
        for i in 0..=100 {
            let depth = i as f32 / 100.0;
            let expected = (-exact(&view, &casters, depth.into())).exp();
            let found = f64::from(texel.transmittance(depth));
            assert!((found - expected).abs() < 1e-5, "{depth}: {found}, not {expected}");
        }
    }
}
