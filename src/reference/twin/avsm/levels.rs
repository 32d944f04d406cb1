//! CPU twin of glsl/maps/curve/levels.comp: the curve of a texel of a level of detail, in f32.

use super::curve::{Build, Curve};
use super::node::Interpolation;
use crate::reference::twin::sums::DARK;

/// What the optical depth of light that is gone is taken for.
const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// One of the four below: (depth, value) of its nodes in use, depths rising, and how many of them have been passed.
struct Below<'a> {
    nodes: &'a [(f32, f32)],
    passed: usize,
}

impl Below<'_> {
    fn ahead(&self) -> f32 {
        self.nodes.get(self.passed).map_or(f32::INFINITY, |node| node.0)
    }

    fn transmittance(&self, depth: f32, interpolation: Interpolation) -> f32 {
        let Some(before) = self.passed.checked_sub(1).map(|i| self.nodes[i]) else { return 1.0 };
        let value = match self.nodes.get(self.passed) {
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
}

/// The mean of four curves, compressed; `build` is that of the map.
pub fn merged(below: [&[(f32, f32)]; 4], build: Build) -> Curve {
    let mut below = below.map(|nodes| Below { nodes, passed: 0 });
    let mut curve = Curve::new(Build { work: build.nodes, turns: 0, ..build });
    let unshadowed = if build.interpolation == Interpolation::Linear { 1.0 } else { 0.0 };
    let mean = |below: &[Below; 4], depth: f32| {
        let mean = below.iter().fold(0.0, |sum, one| sum + 0.25 * one.transmittance(depth, build.interpolation));
        if mean < 1.0 { (-mean.max(1e-35).ln()).min(MAX_OPTICAL_DEPTH) } else { 0.0 }
    };
    let mut last = 0.0f32;
    while last < DARK {
        let depth = below.iter().map(Below::ahead).fold(f32::INFINITY, f32::min);
        let Some(i) = below.iter().position(|one| one.ahead() == depth && depth < f32::INFINITY) else { break };
        let node = below[i].nodes[below[i].passed];
        if below[i].passed == 0 && !curve.nodes().is_empty() && node.1 != unshadowed {
            last = last.max(mean(&below, depth));
            curve.append(depth, last);
        }
        let same = below[i].passed > 0 && below[i].nodes[below[i].passed - 1] == node;
        below[i].passed += 1;
        if !same {
            last = last.max(mean(&below, depth));
            curve.append(depth, last);
        }
    }
    curve.reduce();
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
        /// Behind all nodes, and wherever there is room for every node at these, it is the mean.
        #[test]
        fn it_is_the_mean(curves in curves()) {
            let build = |nodes| Build { nodes, work: nodes, interpolation: Interpolation::Exponential, nudge: true, turns: 0 };
            let below = || [0, 1, 2, 3].map(|i| &curves[i][..]);
            let of = |depth: f32| {
                let one = |nodes: &Vec<(f32, f32)>| {
                    let mut curve = Below { nodes, passed: 0 };
                    while curve.ahead() <= depth {
                        curve.passed += 1;
                    }
                    f64::from(curve.transmittance(depth, Interpolation::Exponential))
                };
                curves.iter().map(one).sum::<f64>() / 4.0
            };
            let (small, large) = (merged(below(), build(8)), merged(below(), build(64)));
            for curve in [&small, &large] {
                prop_assert!((f64::from(curve.transmittance(2.0)) - of(2.0)).abs() < 1e-5);
                prop_assert!(curve.nodes().windows(2).all(|n| n[0].0 <= n[1].0 && n[0].1 <= n[1].1 + 1e-6), "{curve:?}");
            }
            for (depth, _) in curves.iter().flatten() {
                prop_assert!((f64::from(large.transmittance(*depth)) - of(*depth)).abs() < 1e-5, "at {depth}");
            }
        }
    }
}
