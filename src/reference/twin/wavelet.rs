//! CPU twin of glsl/technique/wavelet/: the optical depth of a ray in Haar wavelets, in f32.

/// Calls `add` with what a segment adds to the 2^(rank + 1) sums of a tree: the mean of the optical depth over all of the range, then
/// node after node, level after level, by how much the mean over its second half is more than that over its first. Places are shares of
/// the range. A node that the segment does not reach is not called. Twin: technique_sums.
pub fn sums([entry, exit]: [f32; 2], optical_depth: f32, rank: usize, mut add: impl FnMut(usize, f32)) {
    let mean = |low: f32, high: f32| optical_depth * mean_share(entry, exit, low, high);
    add(0, mean(0.0, 1.0));
    for level in 0..=rank {
        let count = 1usize << level;
        let side = 1.0 / count as f32;
        let node = |place: f32| ((place / side) as usize).min(count - 1);
        for n in node(entry)..=node(exit) {
            let low = n as f32 * side;
            let middle = low + 0.5 * side;
            add(count + n, mean(middle, low + side) - mean(low, middle));
        }
    }
}

/// The mean over [low, high] of the share of a segment that lies before a place. Twin: mean_share.
fn mean_share(entry: f32, exit: f32, low: f32, high: f32) -> f32 {
    let (from, to) = (entry.clamp(low, high), exit.clamp(low, high));
    // Behind the exit all of it; along it the mean of where it begins and ends.
    let length = (exit - entry).max(LEAST_LENGTH);
    let along = (to - from) * (0.5 * ((from - entry) + (to - entry)) / length).min(1.0);
    (along + (high - to)) / (high - low)
}

/// What is shorter is a step. Twin: LEAST_LENGTH.
const LEAST_LENGTH: f32 = 1e-20;

/// The means of the optical depth over the intervals, from the sums of the tree. Twin: unfolded.
pub fn unfold(sums: &[f32]) -> Vec<f32> {
    let mut means = vec![sums[0]];
    while means.len() < sums.len() {
        let nodes = &sums[means.len()..2 * means.len()];
        means = means.iter().zip(nodes).flat_map(|(mean, more)| [mean - 0.5 * more, mean + 0.5 * more]).collect();
    }
    means
}

/// The optical depth to a share of the range, 0 to 1: means stand in the middles of their intervals, 0 at the range's beginning and
/// `total` at its end, and between them it is linear. Twin: wavelet_optical_depth.
pub fn optical_depth(means: &[f32], total: f32, share: f32) -> f32 {
    let at = share * means.len() as f32 - 0.5;
    let below = at.floor();
    let value = |i: i32| match i {
        i if i < 0 => 0.0,
        i => means.get(i as usize).copied().unwrap_or(total),
    };
    let (low, high) = (value(below as i32), value(below as i32 + 1));
    // Half an interval to either end.
    let part = at - below;
    let part = if below < 0.0 {
        2.0 * part - 1.0
    } else if below as usize + 1 == means.len() {
        2.0 * part
    } else {
        part
    };
    low + (high - low) * part.clamp(0.0, 1.0)
}
