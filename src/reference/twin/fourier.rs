//! CPU twin of glsl/technique/fourier/: the optical depth of a ray as a Fourier series, in f32.

use super::harmonics::{cis, harmonics, turned};
use std::f32::consts::PI;

/// Calls `add` with what a segment adds to each of `coefficients` sums: its optical depth, then that times the mean cosine and
/// sine of each harmonic. Places are shares of the range. Twin: technique_sums.
pub fn sums([entry, exit]: [f32; 2], optical_depth: f32, coefficients: usize, mut add: impl FnMut(usize, f32)) {
    add(0, optical_depth);
    harmonics(entry, exit, (coefficients - 1) / 2, |k, mean| {
        add(2 * k - 1, optical_depth * mean[0]);
        add(2 * k, optical_depth * mean[1]);
    });
}

/// The optical depth to a share of the range, 0 to 1; never below 0 and never above all. Twin: fourier_optical_depth.
pub fn optical_depth(sums: &[f32], share: f32) -> f32 {
    let once = cis(share);
    let (mut depth, mut at) = (sums[0] * share, once);
    for (k, pair) in (1..).zip(sums[1..].chunks_exact(2)) {
        depth += (pair[0] * at[1] + pair[1] * (1.0 - at[0])) / (PI * k as f32);
        at = turned(at, once);
    }
    depth.clamp(0.0, sums[0])
}
