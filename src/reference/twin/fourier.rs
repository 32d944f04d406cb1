//! CPU twin of glsl/technique/fourier/: the optical depth of a ray as a Fourier series, in f32.

use super::harmonics::{cis, harmonics, turned};
use std::f32::consts::PI;

/// What a segment adds to each of `coefficients` sums: its optical depth, then that times the mean cosine and the mean sine of each
/// harmonic. Places are shares of the range. Twin: segment_parts.
pub fn parts([entry, exit]: [f32; 2], optical_depth: f32, coefficients: u32) -> Vec<f32> {
    let mut parts = vec![optical_depth];
    harmonics(entry, exit, (coefficients - 1) / 2, |mean| parts.extend(mean.map(|mean| optical_depth * mean)));
    parts
}

/// The optical depth to a share of the range; never below 0 and never above all. Twin: texel_transmittance.
pub fn optical_depth(sums: &[f32], place: f32) -> f32 {
    if place <= 0.0 || place >= 1.0 {
        return if place <= 0.0 { 0.0 } else { sums[0] };
    }
    let once = cis(place);
    let (mut depth, mut here) = (sums[0] * place, once);
    for (order, pair) in (1..).zip(sums[1..].chunks_exact(2)) {
        depth += (pair[0] * here[1] + pair[1] * (1.0 - here[0])) / (PI * order as f32);
        here = turned(here, once);
    }
    depth.clamp(0.0, sums[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against the series in f64 of segments whose integrals are written out, before it is bounded.
        #[test]
        fn series_of_segments(
            segments in prop::collection::vec((0.0..1.0f64, 1e-3..1.0f64, 0.0..2.0f64), 1..20),
            place in 0.001..0.999f32,
            coefficients in prop_oneof![Just(7u32), Just(15), Just(31)],
        ) {
            let cut: Vec<_> = segments.into_iter().map(|(entry, length, t)| (entry, (entry + length).min(1.0), t)).collect();
            let mut sums = vec![0.0; coefficients as usize];
            for (entry, exit, t) in &cut {
                let of = parts([*entry as f32, *exit as f32], *t as f32, coefficients);
                sums.iter_mut().zip(of).for_each(|(sum, part)| *sum += part);
            }
            let (total, z) = (cut.iter().map(|s| s.2).sum::<f64>(), f64::from(place));
            let mut exact = total * z;
            for k in 1..=(coefficients - 1) / 2 {
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
