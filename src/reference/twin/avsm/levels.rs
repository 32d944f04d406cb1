//! CPU twin of glsl/technique/avsm/levels.comp: the curve of a texel of a level of detail, in f32.

use super::curve::{Build, Curve};
use super::node::Interpolation;

/// What the optical depth of light that is gone is taken for.
const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// What one of the four below, (depth, value) of its nodes in use, lets through there. Twin: curve_at.
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

/// How far into the range, 0 to 1, node `i` of `count` stands, by the means at the ends of even steps. Twin: node_place.
fn node_place(means: &[f32], i: usize, count: usize) -> f32 {
    let steps = means.len() - 1;
    if i == 0 || i == count - 1 {
        return if i == 0 { 0.0 } else { 1.0 };
    }
    let loss = means[0] - means[steps];
    let wanted = i as f32 / (count - 1) as f32;
    let mut before = 0.0;
    for (k, mean) in means.iter().enumerate().skip(1) {
        let depth = k as f32 / steps as f32;
        let way = if loss > 0.0 { 0.5 * (depth + (means[0] - mean) / loss) } else { depth };
        if way >= wanted {
            return ((k - 1) as f32 + ((wanted - before) / (way - before)).clamp(0.0, 1.0)) / steps as f32;
        }
        before = way;
    }
    1.0
}

/// The mean of four curves at as many nodes as `build` has, that of the map.
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
    let at = |place: f32| front * (1.0 - place) + back * place;
    let steps = if count < 8 { 16 } else { 2 * count };
    let means: Vec<f32> = (0..=steps).map(|k| mean(at(k as f32 / steps as f32))).collect();
    let mut last = 0.0f32;
    for i in 0..count {
        let depth = if i + 1 == count { back } else { at(node_place(&means, i, count)) };
        let through = mean(depth);
        last = last.max(if through < 1.0 { (-through.max(1e-35).ln()).min(MAX_OPTICAL_DEPTH) } else { 0.0 });
        curve.append(depth, last);
    }
    curve
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
        /// At its nodes and behind them it is the mean; in between it does not rise, and more nodes are nearer.
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
            let off = |count| {
                let curve = merged(below(), build(count));
                (0..200).map(|i| (i as f32 + 0.5) / 200.0).map(|at| (f64::from(curve.transmittance(at)) - of(at)).abs()).sum::<f64>()
            };
            // Steps are told to a part of the range.
            prop_assert!(off(256) <= off(8) + 1.0, "{} against {}", off(256), off(8));
        }
    }

    /// Four alike are what they are, where these are even from their front to their back; and strands of two alternating texels, one
    /// dark and one clear, leave half of the light.
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
