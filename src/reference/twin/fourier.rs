//! CPU twin of glsl/technique/fourier/: the optical depth of a ray as a Fourier series, in f32.

use super::harmonics::{cis, harmonics, turned};
use std::f32::consts::PI;

/// Returns what a segment between two positions in the range adds to each sum. To the first sum it adds its optical depth; to each further
/// sum, its optical depth times the mean, over the segment, of the harmonic's cosine or sine. Twin: segment_parts.
pub fn parts<const N: usize>([entry, exit]: [f32; 2], optical_depth: f32) -> [f32; N] {
    let mut parts = [optical_depth; N];
    for (pair, mean) in parts[1..].as_chunks_mut::<2>().0.iter_mut().zip(harmonics(entry, exit)) {
        *pair = mean.map(|mean| optical_depth * mean);
    }
    parts
}

/// Returns the optical depth up to a position in the range, clamped between 0 and the total optical depth. Twin: texel_transmittance.
pub fn optical_depth(sums: &[f32], place: f32) -> f32 {
    if place <= 0.0 || place >= 1.0 {
        return if place <= 0.0 { 0.0 } else { sums[0] };
    }
    let once = cis(place);
    let (mut depth, mut here) = (sums[0] * place, once);
    for (order, pair) in (1..).zip(sums[1..].as_chunks::<2>().0) {
        depth += (pair[0] * here[1] + pair[1] * (1.0 - here[0])) / (PI * order as f32);
        here = turned(here, once);
    }
    depth.clamp(0.0, sums[0])
}

#[cfg(test)]
mod tests {
    use super::super::sum_checks::{casters, invariants, slab_error};
    use super::*;
    use proptest::prelude::*;

    /// Returns the sums after storage as half floats.
    fn halves<const N: usize>(sums: [f32; N]) -> [f32; N] {
        sums.map(|sum| half::f16::from_f32(sum.clamp(-65504.0, 65504.0)).to_f32())
    }

    /// For a slab that fills the range, one term is exact. In a wider range, more terms reduce the error.
    #[test]
    fn a_slab() {
        assert!(slab_error([0.3, 0.7], parts::<7>, |sums, at| optical_depth(sums, at)) < 1e-6);
        let few = slab_error([0.0, 1.0], parts::<7>, |sums, at| optical_depth(sums, at));
        let many = slab_error([0.0, 1.0], parts::<31>, |sums, at| optical_depth(sums, at));
        assert!(few < 0.02 && many < few / 6.0, "{few}, {many}");
    }

    proptest! {
        /// Ringing is bounded for any casters.
        #[test]
        fn rings_within_bounds(all in casters()) {
            invariants::<7>(&all, parts, |sums| sums, |sums, at| optical_depth(sums, at), 1.0)?;
            invariants::<31>(&all, parts, |sums| sums, |sums, at| optical_depth(sums, at), 1.0)?;
            invariants::<15>(&all, parts, halves, |sums, at| optical_depth(sums, at), 1.0)?;
        }

        /// Compares with the series in f64, with its integrals over segments written out.
        #[test]
        fn series_of_segments(
            segments in prop::collection::vec((0.0..1.0f64, 1e-3..1.0f64, 0.0..2.0f64), 1..20),
            place in 0.001..0.999f32,
        ) {
            let cut: Vec<_> = segments.into_iter().map(|(entry, length, t)| (entry, (entry + length).min(1.0), t)).collect();
            let mut sums = [0.0; 15];
            for (entry, exit, t) in &cut {
                let of: [f32; 15] = parts([*entry as f32, *exit as f32], *t as f32);
                sums.iter_mut().zip(of).for_each(|(sum, part)| *sum += part);
            }
            let (total, z) = (cut.iter().map(|s| s.2).sum::<f64>(), f64::from(place));
            let mut exact = total * z;
            for k in 1..=7u8 {
                let turn = std::f64::consts::TAU * f64::from(k);
                for (entry, exit, t) in cut.iter().filter(|s| s.1 > s.0) {
                    let slope = t / (exit - entry);
                    let [cos, sin] = [(turn * exit).sin() - (turn * entry).sin(), (turn * entry).cos() - (turn * exit).cos()];
                    exact += 2.0 * slope * (cos * (turn * z).sin() + sin * (1.0 - (turn * z).cos())) / turn / turn;
                }
            }
            let found = f64::from(optical_depth(&sums, place));
            prop_assert!((found - exact.clamp(0.0, total)).abs() < 2e-5 * total.max(1.0), "{found}, not {exact}");
        }
    }
}
