//! Properties of every technique that stores sums over a texel's casters.

use super::segment::texel_segment;
use super::sums::{DARK, bound};
use super::texel_sums::{Range, binned, place};
use crate::scene::tests::along_the_axis;
use crate::scene::{Caster, View};
use proptest::prelude::*;

/// Generates spheres along the light: z, radius and extinction. Some are empty, some as thin as smoke, some opaque.
pub fn casters() -> impl Strategy<Value = Vec<(f32, f32, f32)>> {
    let density = prop_oneof![Just(0.0f32), 0.0..3.0f32, Just(1e6f32)];
    prop::collection::vec((-1.5..1.5f32, 0.01..0.5f32, density), 0..40)
}

/// Returns the exact optical depth up to a depth, in f64.
fn exact(view: &View, casters: &[Caster], depth: f64) -> f64 {
    let of = |c: &Caster| {
        let s = texel_segment(view, [0, 0], c)?;
        let (entry, exit) = (f64::from(s.entry), f64::from(s.exit));
        let share = if depth >= exit { 1.0 } else { ((depth - entry) / (exit - entry)).max(0.0) };
        Some(f64::from(s.optical_depth) * share)
    };
    casters.iter().filter_map(of).sum()
}

/// Checks a technique's transmittance: it is in [0, 1], 1 in front of all casters, the product of their transmittances behind them, and
/// rises by at most `rise`. Any order of casters gives the same bits. `parts` returns a segment's contribution to the sums, `kept` rounds
/// the sums for storage, and `optical_depth` evaluates them at a position in the range.
pub fn invariants<const N: usize>(
    all: &[(f32, f32, f32)],
    parts: impl Fn([f32; 2], f32) -> [f32; N],
    kept: impl Fn([f32; N]) -> [f32; N],
    optical_depth: impl Fn(&[f32; N], f32) -> f32,
    rise: f32,
) -> Result<(), TestCaseError> {
    let (view, casters) = along_the_axis(all);
    let bound = bound(&casters, DARK);
    let product = (-exact(&view, &casters, 2.0)).exp();
    let backwards: Vec<_> = casters.iter().rev().copied().collect();
    for of in [Range::Scene, Range::Texel] {
        let (range, sums) = binned((&view, [0, 0], &casters, bound), of, &parts);
        prop_assert_eq!((range, sums), binned((&view, [0, 0], &backwards, bound), of, &parts));
        let sums = kept(sums);
        let transmittance = |depth: f32| (-optical_depth(&sums, place(range, depth))).exp();
        let mut last = transmittance(if of == Range::Texel { range[0] } else { -1e-3 });
        prop_assert_eq!(last, 1.0);
        for i in 0..=128 {
            let t = transmittance(i as f32 / 128.0);
            prop_assert!((0.0..=1.0).contains(&t), "{of:?}: {t} at {i}");
            prop_assert!(t <= last + rise, "{of:?}: {t} after {last} at {i}");
            last = t;
        }
        prop_assert!((f64::from(last) - product).abs() < 3e-4, "{of:?}: {last}, not {product}");
    }
    Ok(())
}

/// Returns the mean error over the depths of a slab, a uniform medium between 0.3 and 0.7 of the range.
pub fn slab_error<const N: usize>(
    range: [f32; 2],
    parts: impl Fn([f32; 2], f32) -> [f32; N],
    optical_depth: impl Fn(&[f32; N], f32) -> f32,
) -> f32 {
    let sums = parts([0.3, 0.7].map(|depth| place(range, depth)), 2.0);
    let off = |depth: f32| {
        let exact = (-2.0 * ((depth - 0.3) / 0.4).clamp(0.0, 1.0)).exp();
        ((-optical_depth(&sums, place(range, depth))).exp() - exact).abs()
    };
    (0..=1000).map(|i| off(i as f32 / 1000.0)).sum::<f32>() / 1001.0
}
