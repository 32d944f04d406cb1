//! CPU twin of glsl/maps/harmonics.glsl: sines and cosines of harmonics, and their means over segments of a ray, in f32.

use std::f32::consts::{PI, TAU};

/// Returns the cosine and sine of an angle in full circles. Twin: cis.
pub fn cis(turns: f32) -> [f32; 2] {
    let quarters = (4.0 * turns + 0.5).floor();
    let angle = TAU * (turns - 0.25 * quarters);
    let square = angle * angle;
    let sin = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))));
    let cos = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)));
    match quarters as i32 & 3 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

/// Returns the product of two complex numbers. Twin: turned.
pub fn turned(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Returns the means of [`cis`] at 1, 2, 3, … times the position, over positions from `entry` to `exit`. Twins: first_harmonic and
/// next_harmonic.
pub fn harmonics(entry: f32, exit: f32) -> impl Iterator<Item = [f32; 2]> {
    let length = exit - entry;
    let (once, half) = (cis(0.5 * (entry + exit)), cis(0.5 * length));
    let (mut at, mut chord) = (once, half);
    (1..).map(move |order| {
        // The mean over a chord, as a share of the value at its midpoint: sin(π order length) / (π order length).
        let share = if length > LEAST_LENGTH { chord[1] / (PI * order as f32 * length) } else { 1.0 };
        let mean = at.map(|part| part * share);
        (at, chord) = (turned(at, once), turned(chord, half));
        mean
    })
}

/// A segment shorter than this is a step. Twin: LEAST_LENGTH.
const LEAST_LENGTH: f32 = 1e-20;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn circles_are_circles(turns in -3.0..3.0f32) {
            let angle = std::f64::consts::TAU * f64::from(turns);
            let [cos, sin] = cis(turns).map(f64::from);
            prop_assert!((cos - angle.cos()).abs() < 4e-7 && (sin - angle.sin()).abs() < 4e-7, "{cos}, {sin}");
        }

        /// Compares with the integrals in f64.
        #[test]
        fn segments_are_integrated(entry in 0.0..1.0f32, length in prop_oneof![0.0..1.0f32, 0.0..1e-5f32, Just(0.0)]) {
            let exit = (entry + length).min(1.0);
            let mut worst = 0f64;
            for (k, mean) in (1..=15).zip(harmonics(entry, exit)) {
                let at = |z: f32| (std::f64::consts::TAU * f64::from(k) * f64::from(z)).sin_cos();
                let around = std::f64::consts::TAU * f64::from(k) * f64::from(exit - entry);
                let ((s0, c0), (s1, c1)) = (at(entry), at(exit));
                let exact = if around > 1e-3 { [(s1 - s0) / around, (c0 - c1) / around] } else { [c0, s0] };
                let off = mean.into_iter().zip(exact).map(|(m, e)| (f64::from(m) - e).abs()).fold(0.0, f64::max);
                worst = worst.max(off - if around > 1e-3 { 0.0 } else { around });
            }
            prop_assert!(worst < 1e-5, "{worst}");
        }
    }
}
