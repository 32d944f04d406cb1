//! CPU twin of glsl/technique/wavelet/: the optical depth of a ray in Haar wavelets, as the means that these make, in f32.

/// What a segment adds to the sums of `means` intervals of the range: the mean of its optical depth up to each place, then all of
/// it. Places are shares of the range. Twin: segment_parts.
pub fn parts(place: [f32; 2], optical_depth: f32, means: u32) -> Vec<f32> {
    let side = 1.0 / means as f32;
    let interval = |i| {
        let low = i as f32 * side;
        optical_depth * mean_share(place, low, low + side)
    };
    (0..means).map(interval).chain([optical_depth]).collect()
}

/// The mean from `low` to `high` of the share of a segment that lies before a place. Twin: mean_share.
fn mean_share([entry, exit]: [f32; 2], low: f32, high: f32) -> f32 {
    let (from, to) = (entry.clamp(low, high), exit.clamp(low, high));
    // Behind the exit all of it; along it the mean of where it begins and ends.
    let length = (exit - entry).max(LEAST_LENGTH);
    let along = (to - from) * (0.5 * ((from - entry) + (to - entry)) / length).min(1.0);
    (along + (high - to)) / (high - low)
}

/// What is shorter is a step. Twin: LEAST_LENGTH.
const LEAST_LENGTH: f32 = 1e-20;

/// The optical depth to a share of the range: means stand in the middles of their intervals, none at the range's beginning and all at its
/// end, and between them it is linear. Twin: texel_transmittance.
pub fn optical_depth(sums: &[f32], place: f32) -> f32 {
    let means = sums.len() - 1;
    if place <= 0.0 || place >= 1.0 {
        return if place <= 0.0 { 0.0 } else { sums[means] };
    }
    let middle = place * means as f32 - 0.5;
    let (next, along) = ((middle.floor() + 1.0) as usize, middle - middle.floor());
    // Half an interval to either end.
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
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against the integral of the curve in f64, cut fine.
        #[test]
        fn means_are_means(entry in 0.0..1.0f32, length in prop_oneof![0.0..1.0f32, Just(0.0)], rank in 2u32..5) {
            let exit = (entry + length).min(1.0);
            let means = 2 << rank;
            let share = |z: f64| if z >= f64::from(exit) { 1.0 } else { ((z - f64::from(entry)) / f64::from(exit - entry)).max(0.0) };
            let found = parts([entry, exit], 3.0, means);
            let cuts = 4096 / means;
            for i in 0..means {
                let at = |j: u32| (f64::from(i * cuts + j) + 0.5) / 4096.0;
                let exact = 3.0 * (0..cuts).map(|j| share(at(j))).sum::<f64>() / f64::from(cuts);
                let off = f64::from(found[i as usize]) - exact;
                // A step lies anywhere in its cut.
                prop_assert!(off.abs() < 3.0 / f64::from(cuts) + 1e-5, "{i}: {off}");
            }
            prop_assert_eq!(found[means as usize], 3.0);
        }
    }
}
