//! CPU twin of glsl/technique/wavelet/: the optical depth of a ray in Haar wavelets, stored as means over intervals, in f32.

/// Returns what a segment between two positions in the range adds to each sum. Each sum but the last belongs to an interval of the range.
/// The segment adds to it the mean, over the interval's positions, of its optical depth up to the position. To the last sum it adds its
/// whole optical depth.
/// Twin: segment_parts.
pub fn parts<const N: usize>(place: [f32; 2], optical_depth: f32) -> [f32; N] {
    let side = 1.0 / (N - 1) as f32;
    std::array::from_fn(|i| match i as f32 * side {
        _ if i + 1 == N => optical_depth,
        low => optical_depth * mean_share(place, low, low + side),
    })
}

/// Returns the mean, from `low` to `high`, of the share of a segment that lies before a position. Twin: mean_share.
fn mean_share([entry, exit]: [f32; 2], low: f32, high: f32) -> f32 {
    let (from, to) = (entry.clamp(low, high), exit.clamp(low, high));
    // Positions behind the exit see the whole segment; positions along it see on average the mean of the shares at both ends.
    let length = (exit - entry).max(LEAST_LENGTH);
    let along = (to - from) * (0.5 * ((from - entry) + (to - entry)) / length).min(1.0);
    (along + (high - to)) / (high - low)
}

/// A segment shorter than this is a step. Twin: LEAST_LENGTH.
const LEAST_LENGTH: f32 = 1e-20;

/// Returns the optical depth up to a position in the range, interpolated linearly. Each mean applies at the centre of its interval. Optical
/// depth is 0 at the start of the range and the total at its end. Twin: texel_transmittance.
pub fn optical_depth(sums: &[f32], place: f32) -> f32 {
    let means = sums.len() - 1;
    if place <= 0.0 || place >= 1.0 {
        return if place <= 0.0 { 0.0 } else { sums[means] };
    }
    let middle = place * means as f32 - 0.5;
    let (next, along) = ((middle.floor() + 1.0) as usize, middle - middle.floor());
    // The first and the last stretch are half an interval long.
    let along = match next {
        0 => 2.0 * along - 1.0,
        _ if next == means => 2.0 * along,
        _ => along,
    };
    let low = if next == 0 { 0.0 } else { sums[next - 1] };
    low + (sums[next] - low) * along
}

#[cfg(test)]
mod tests {
    use super::super::sum_checks::{casters, invariants, slab_error};
    use super::*;
    use proptest::prelude::*;

    /// For a slab that fills the range, optical depth is linear and means are exact. In a wider range, more means reduce the error.
    #[test]
    fn a_slab() {
        assert!(slab_error([0.3, 0.7], parts::<9>, |sums, at| optical_depth(sums, at)) < 1e-6);
        let few = slab_error([0.0, 1.0], parts::<9>, |sums, at| optical_depth(sums, at));
        let many = slab_error([0.0, 1.0], parts::<33>, |sums, at| optical_depth(sums, at));
        assert!(many < few / 10.0, "a sixteenth where the error is of the second order: {few}, {many}");
    }

    proptest! {
        #[test]
        fn never_rises(all in casters()) {
            let halves = |sums: [f32; 17]| sums.map(|sum| half::f16::from_f32(sum.min(65504.0)).to_f32());
            invariants::<9>(&all, parts, |sums| sums, |sums, at| optical_depth(sums, at), 1e-6)?;
            invariants::<33>(&all, parts, |sums| sums, |sums, at| optical_depth(sums, at), 1e-6)?;
            invariants::<17>(&all, parts, halves, |sums, at| optical_depth(sums, at), 1e-6)?;
        }

        /// Compares with a numerical integral of the curve in f64.
        #[test]
        fn means_are_means(entry in 0.0..1.0f32, length in prop_oneof![0.0..1.0f32, Just(0.0)]) {
            let exit = (entry + length).min(1.0);
            let share = |z: f64| if z >= f64::from(exit) { 1.0 } else { ((z - f64::from(entry)) / f64::from(exit - entry)).max(0.0) };
            let found: [f32; 17] = parts([entry, exit], 3.0);
            let cuts = 256;
            for i in 0..16 {
                let at = |j: u32| (f64::from(i * cuts + j) + 0.5) / 4096.0;
                let exact = 3.0 * (0..cuts).map(|j| share(at(j))).sum::<f64>() / f64::from(cuts);
                let off = f64::from(found[i as usize]) - exact;
                // A step may lie anywhere within an interval of the numerical integral.
                prop_assert!(off.abs() < 3.0 / f64::from(cuts) + 1e-5, "{i}: {off}");
            }
            prop_assert_eq!(found[16], 3.0);
        }
    }
}
