//! CPU twin of glsl/maps/curve/levels.comp, in f32: the curve of a texel in a coarser level of detail.

use super::curve::{Build, Curve};
use super::node::Interpolation;

/// Optical depth stored where no light is left.
const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// Returns the transmittance at `depth` of one of the four curves in the level below, from its nodes (depth, value). Twin: curve_at.
fn below_at(nodes: &[(f32, f32)], depth: f32, interpolation: Interpolation) -> f32 {
    let passed = nodes.iter().filter(|node| node.0 <= depth).count();
    let Some(before) = passed.checked_sub(1).map(|i| nodes[i]) else { return 1.0 };
    let value = match nodes.get(passed) {
        Some(ahead) if ahead.0 > before.0 => {
            let along = ((depth - before.0) / (ahead.0 - before.0)).clamp(0.0, 1.0);
            before.1 * (1.0 - along) + ahead.1 * along
        }
        _ => before.1,
    };
    match interpolation {
        Interpolation::Linear => value,
        Interpolation::Exponential => (-value).exp(),
    }
}

/// Returns the number of equal depth steps at whose ends nodes may be placed. Twin: STEPS.
fn steps(nodes: usize) -> usize {
    if nodes < 16 { 16 } else { nodes - 1 }
}

/// Chooses at most `count` ends as nodes, always including the last, so that the sum of squared differences between the curve and `means`
/// is minimal. Returns the ends and that sum. Twin: choose_nodes.
fn chosen(means: &[f32], values: &[f32], count: usize, through: impl Fn(f32) -> f32) -> (Vec<usize>, f32) {
    let line = |from: usize, to: usize| {
        let off = |k: usize| {
            let along = (k - from) as f32 / (to - from) as f32;
            through(values[from] * (1.0 - along) + values[to] * along) - means[k]
        };
        (from + 1..to).map(|k| off(k).powi(2)).sum::<f32>()
    };
    let front = |to: usize| means[..to].iter().map(|mean| (1.0 - mean).powi(2)).sum::<f32>();
    let mut best: Vec<(Vec<usize>, f32)> = (0..means.len()).map(|to| (vec![to], front(to))).collect();
    for _ in 1..count {
        let next = |to: usize| {
            let mut least = best[to].clone();
            for (from, (ends, before)) in best.iter().enumerate().take(to) {
                let cost = before + line(from, to);
                if cost < least.1 {
                    least = ([&ends[..], &[to]].concat(), cost);
                }
            }
            least
        };
        best = (0..means.len()).map(next).collect();
    }
    best.swap_remove(means.len() - 1)
}

/// Returns the mean of four curves, with as many nodes as `build`, the map's own, allows.
pub fn merged(below: [&[(f32, f32)]; 4], build: Build) -> Curve {
    let Build { nodes: count, interpolation, .. } = build;
    let mut curve = Curve::new(Build { work: count, turns: 0, ..build });
    let unshadowed = if interpolation == Interpolation::Linear { 1.0 } else { 0.0 };
    let casts = below.iter().filter(|nodes| nodes.last().is_some_and(|node| node.1 != unshadowed));
    let depths = casts.flat_map(|nodes| nodes.iter().map(|node| node.0));
    let [front, back] = depths.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], depth| [a.min(depth), b.max(depth)]);
    if front > back {
        return curve;
    }
    let mean = |depth: f32| {
        let sum = below.iter().fold(0.0, |sum, nodes| sum + 0.25 * below_at(nodes, depth, interpolation));
        f32::min(sum, 1.0)
    };
    let steps = steps(count);
    let depth = |end: usize| {
        let along = end as f32 / steps as f32;
        front * (1.0 - along) + back * along
    };
    let means: Vec<f32> = (0..=steps).map(|end| mean(depth(end))).collect();
    let optical_depth = |mean: &f32| if *mean < 1.0 { (-mean.max(1e-35).ln()).min(MAX_OPTICAL_DEPTH) } else { 0.0 };
    let optical_depths: Vec<f32> = means.iter().map(optical_depth).collect();
    let ends = match interpolation {
        _ if count > steps => (0..=steps).collect(),
        Interpolation::Linear => chosen(&means, &means, count, |value| value).0,
        Interpolation::Exponential => chosen(&means, &optical_depths, count, |value| (-value).exp()).0,
    };
    let mut last = 0.0f32;
    for end in ends {
        last = last.max(optical_depths[end]);
        curve.append(depth(end), last);
    }
    curve
}

/// Returns the cost of a curve that replaces the four curves `below`: the sum of squared differences from their mean, at the ends of equal
/// steps from their first node to their last. No curve with nodes at such ends costs less than [`merged`].
pub fn cost(below: [&[(f32, f32)]; 4], build: Build, transmittance: impl Fn(f32) -> f32) -> f32 {
    let unshadowed = if build.interpolation == Interpolation::Linear { 1.0 } else { 0.0 };
    let casts = below.iter().filter(|nodes| nodes.last().is_some_and(|node| node.1 != unshadowed));
    let depths = casts.flat_map(|nodes| nodes.iter().map(|node| node.0));
    let [front, back] = depths.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], depth| [a.min(depth), b.max(depth)]);
    if front > back {
        return 0.0;
    }
    let steps = steps(build.nodes);
    let off = |end: usize| {
        let along = end as f32 / steps as f32;
        let depth = front * (1.0 - along) + back * along;
        let mean = below.iter().fold(0.0, |sum, nodes| sum + 0.25 * below_at(nodes, depth, build.interpolation));
        (transmittance(depth) - mean).powi(2)
    };
    (0..=steps).map(off).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn curves() -> impl Strategy<Value = [Vec<(f32, f32)>; 4]> {
        // Coarse steps make equal depths and equal values common.
        let steps = prop::collection::vec((0u8..8, prop_oneof![0u8..4, Just(90)]), 0..8);
        let curve = steps.prop_map(|steps| {
            let mut at = (0.0, 0.0);
            let next = |(depth, value)| {
                at = (at.0 + f32::from(depth) / 64.0, at.1 + f32::from(value) / 4.0);
                at
            };
            steps.into_iter().map(next).collect::<Vec<_>>()
        });
        [curve.clone(), curve.clone(), curve.clone(), curve]
    }

    proptest! {
        /// The merged curve equals the mean at its nodes and behind them, and never rises between them.
        #[test]
        fn it_is_the_mean(curves in curves()) {
            let interpolation = Interpolation::Exponential;
            let build = |nodes| Build { nodes, work: nodes, interpolation, nudge: true, turns: 0 };
            let below = || [0, 1, 2, 3].map(|i| &curves[i][..]);
            let of = |depth: f32| {
                let sum: f64 = below().iter().map(|nodes| f64::from(below_at(nodes, depth, interpolation))).sum();
                sum / 4.0
            };
            for count in [4, 8, 16] {
                let curve = merged(below(), build(count));
                prop_assert!((f64::from(curve.transmittance(2.0)) - of(2.0)).abs() < 1e-5);
                prop_assert!(curve.nodes().windows(2).all(|n| n[0].0 <= n[1].0 && n[0].1 <= n[1].1), "{curve:?}");
                for (depth, value) in curve.nodes() {
                    prop_assert!((f64::from((-value).exp()) - of(*depth)).abs() < 1e-5, "{curve:?} at {depth}");
                }
            }
            // No curve with as many nodes at other ends comes closer: here every second, third or fifth end.
            let build = build(8);
            let curve = merged(below(), build);
            let its = cost(below(), build, |depth| curve.transmittance(depth));
            if let Some((front, back)) = curve.nodes().last().map(|last| (range_front(&curves), last.0)) {
                for step in [2usize, 3, 5] {
                    let mut other = Curve::new(build);
                    for end in (0..16).step_by(step).take(7).chain([16]) {
                        let depth = front * (1.0 - end as f32 / 16.0) + back * (end as f32 / 16.0);
                        other.append(depth, -(of(depth).max(1e-35).ln()) as f32);
                    }
                    let others = cost(below(), build, |depth| other.transmittance(depth));
                    prop_assert!(its <= others + 1e-5, "{its} against {others} of every {step}");
                }
            }
        }
    }

    fn range_front(curves: &[Vec<(f32, f32)>; 4]) -> f32 {
        let casts = curves.iter().filter(|nodes| nodes.last().is_some_and(|node| node.1 > 0.0));
        casts.map(|nodes| nodes[0].0).fold(f32::INFINITY, f32::min)
    }

    /// Four equal slabs of uniform extinction merge into the same slab. If two of four texels hold a dark strand, half of the light is
    /// left.
    #[test]
    fn closed_forms() {
        let interpolation = Interpolation::Exponential;
        let build = Build { nodes: 8, work: 8, interpolation, nudge: true, turns: 0 };
        let slab = [(0.25, 0.0), (0.75, 3.0)];
        let curve = merged([&slab; 4], build);
        for i in 0..=100 {
            let depth = i as f32 / 100.0;
            let exact = (-3.0 * ((depth - 0.25) / 0.5).clamp(0.0, 1.0)).exp();
            assert!((curve.transmittance(depth) - exact).abs() < 1e-6, "{depth}: {curve:?}");
        }
        let strand = [(0.5, 80.0)];
        let curve = merged([&strand, &[], &strand, &[]], build);
        assert_eq!([0.49, 0.5, 1.0].map(|depth| curve.transmittance(depth)), [1.0, 0.5, 0.5]);
    }
}
