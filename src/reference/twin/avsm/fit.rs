//! CPU twin of glsl/technique/avsm/fit.glsl: moves nodes to fit the sums in cells better, in f32.

use super::cells::CELLS;
use std::ops::Range;

const REACH: f32 = 0.5;
const STEEP: f32 = 0.0625;
const DIM: f32 = 1e-7;
const STRAIGHT: f32 = 1e-10;

/// A curve before compression, sampled at the ends of evenly spaced cells.
pub(super) struct Ends {
    /// Depth at which the first cell starts.
    pub low: f32,
    pub per_cell: f32,
    /// Nodes from this depth on are not moved.
    pub dark_from: f32,
    /// Optical depth up to the end of each cell.
    pub optical_depth: [f32; CELLS],
}

impl Ends {
    /// Moves nodes (depth, optical depth) closer to the curve in `turns` passes, which alternate between odd and even nodes.
    /// Twin: curve_fit.
    pub(super) fn fit(&self, nodes: &mut [(f32, f32)], turns: usize) {
        for parity in (0..turns).map(|turn| (turn + 1) % 2) {
            for i in (parity..nodes.len()).step_by(2) {
                nodes[i] = self.fitted(nodes, i);
            }
        }
    }

    /// Twin: line_sums.
    fn line_sums(&self, neighbour: (f32, f32), node: (f32, f32), per: f32, range: Range<f32>) -> [f32; 2] {
        let mut sums = [0.0; 2];
        for cell in range.start as usize..range.end as usize {
            let end = (cell + 1) as f32;
            let share = (end - neighbour.0) * per;
            let line = neighbour.1 + (node.1 - neighbour.1) * share;
            let belongs = ((node.0 - end) * per.signum() + 0.5).clamp(0.0, 1.0);
            let optical_depth = self.optical_depth[cell];
            let weight = (-2.0 * optical_depth).exp() * share * belongs;
            sums[0] += weight * share;
            sums[1] += weight * (optical_depth - line);
        }
        sums
    }

    /// Twin: fitted.
    fn fitted(&self, nodes: &[(f32, f32)], i: usize) -> (f32, f32) {
        let node = nodes[i];
        let (is_first, is_last) = (i == 0, i + 1 == nodes.len());
        let dark_from = self.dark_from;
        if (is_first && is_last) || node.0 >= dark_from {
            return node;
        }
        let p = if is_first { node } else { nodes[i - 1] };
        let q = if is_last { node } else { nodes[i + 1] };
        let place = |depth: f32| (depth - self.low) * self.per_cell;
        let (at_p, at, at_q) = (place(p.0), place(node.0), place(q.0));
        let (per_p, per_q) = (1.0 / (at - at_p).max(STEEP), 1.0 / (at_q - at).max(STEEP));
        let (slope_p, slope_q) = ((node.1 - p.1) * per_p, (q.1 - node.1) * per_q);
        let dark = place(dark_from).clamp(0.0, CELLS as f32);
        let sums_p = self.line_sums((at_p, p.1), (at, node.1), per_p, at_p..(at + 0.5).min(dark));
        let sums_q = self.line_sums((at_q, q.1), (at, node.1), -per_q, (at - 0.5).max(at_p)..at_q.min(dark));
        let (wish_p, wish_q) = (sums_p[1] / (sums_p[0] + DIM), sums_q[1] / (sums_q[0] + DIM));
        let (nearest, farthest) =
            (at - REACH * (at - at_p), at + REACH * (if is_last { CELLS as f32 } else { at_q } - at));
        let (moved, value);
        if is_first {
            let wanted = node.1 + wish_q;
            let slope = (q.1 - wanted) * per_q;
            moved = if wanted < 0.0 { (at - wanted / slope).min(farthest) } else { at };
            value = wanted.max(0.0).min(q.1);
        } else if is_last {
            moved = (at - wish_p * slope_p / (slope_p * slope_p + STRAIGHT)).max(nearest).min(farthest);
            value = node.1;
        } else {
            let bend = slope_p - slope_q;
            moved = (at + (wish_q - wish_p) * bend / (bend * bend + STRAIGHT)).max(nearest).min(farthest);
            let by = moved - at;
            let both = sums_p[0] * (wish_p + slope_p * by) + sums_q[0] * (wish_q + slope_q * by);
            value = (node.1 + both / (sums_p[0] + sums_q[0] + DIM)).max(p.1).min(q.1);
        }
        let end = if is_last { node.0.max(self.low + CELLS as f32 / self.per_cell) } else { q.0 };
        ((self.low + moved / self.per_cell).max(p.0).min(end), value)
    }
}

#[cfg(test)]
mod tests {
    use super::super::cells::Cells;
    use super::super::curve::Build;
    use super::super::node::Interpolation;
    use super::*;
    use crate::reference::twin::segment::Segment;
    use proptest::prelude::*;
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;

    /// Upper bound on the optical depth of a few thin segments, as passed to [`Cells::new`].
    const BOUND: u64 = 1 << 12;

    fn build(nodes: usize) -> Build {
        Build { nodes, work: nodes + 2, interpolation: Interpolation::Exponential, nudge: true, turns: 0 }
    }

    fn segments(thick: f32) -> impl Strategy<Value = Vec<Segment>> {
        prop::collection::vec((0.0..1.0f32, 0.0..0.3f32, 0.0..thick), 1..40).prop_map(|list| {
            let segment = |(entry, length, optical_depth)| Segment { entry, exit: entry + length, optical_depth };
            list.into_iter().map(segment).collect()
        })
    }

    /// Returns the sum of the errors in transmittance of a curve through `nodes`, at the cell ends.
    fn error(cells: &Cells, nodes: &[(f32, f32)]) -> f32 {
        let off = |cell: usize| {
            let depth = cells.low + (cell + 1) as f32 / cells.per_cell;
            let behind = nodes.partition_point(|n| n.0 <= depth);
            let value = match (behind.checked_sub(1).map(|i| nodes[i]), nodes.get(behind)) {
                (None, _) => 0.0,
                (Some(p), None) => p.1,
                (Some(p), Some(q)) => p.1 + (q.1 - p.1) * (depth - p.0) / (q.0 - p.0),
            };
            ((-value).exp() - (-cells.optical_depth(cell)).exp()).abs()
        };
        (0..CELLS).map(off).sum()
    }

    /// If the nodes are already exact, fitting does not move the curve.
    #[test]
    fn what_is_exact_stays() {
        // A whole number of units in each cell.
        for optical_depth in [1.0 / 1024.0, 0.5, 6.0] {
            let segment = Segment { entry: 0.25, exit: 0.75, optical_depth };
            let cells = Cells::new(&[segment], BOUND).expect("a segment");
            let mut nodes = cells.curve(build(8)).nodes;
            cells.ends_of_cells().fit(&mut nodes, 8);
            // Sums are rounded to a unit, and a fit may miss each by one more unit.
            let off = error(&cells, &nodes);
            assert!(off < 2.0 * CELLS as f32 * cells.unit, "{optical_depth}: {off}, {nodes:?}");
        }
    }

    /// Fitting lowers the total error of all curves, and hardly raises the error of any single one.
    #[test]
    fn fitted_curves_err_less() {
        let mut runner = TestRunner::deterministic();
        for count in [4, 8, 16] {
            let (mut plain, mut fitted) = (0.0, 0.0);
            for _ in 0..200 {
                let list = segments(0.5).new_tree(&mut runner).expect("segments").current();
                let cells = Cells::new(&list, BOUND).expect("some segments");
                let mut nodes = cells.curve(build(count)).nodes;
                let before = error(&cells, &nodes);
                cells.ends_of_cells().fit(&mut nodes, 3);
                let after = error(&cells, &nodes);
                assert!(after < 1.25 * before + 0.02, "{after}, {before} before: {nodes:?}");
                (plain, fitted) = (plain + before, fitted + after);
            }
            println!("{count} nodes: {fitted} of {plain}");
            assert!(fitted < 0.8 * plain, "{count} nodes: {fitted} of {plain}");
        }
    }

    proptest! {
        /// The last node keeps its value, nodes in the dark stay where they are, and depths and optical depths still rise.
        #[test]
        fn fit_keeps_what_it_must(
            list in segments(4.0),
            dark in prop::option::of((0.0..1.0f32, 0.0..0.2f32)),
            count in prop::sample::select(vec![4usize, 8, 16]),
        ) {
            let mut list = list;
            list.extend(dark.map(|(entry, length)| Segment { entry, exit: entry + length, optical_depth: 40.0 }));
            let cells = Cells::new(&list, BOUND).expect("some segments");
            let plain = cells.curve(build(count)).nodes;
            let mut nodes = plain.clone();
            cells.ends_of_cells().fit(&mut nodes, 4);
            prop_assert_eq!(nodes.len(), plain.len());
            prop_assert_eq!(nodes.last().map(|n| n.1), plain.last().map(|n| n.1));
            let from = cells.dark.map_or(f32::INFINITY, |(from, _)| from);
            for (node, old) in nodes.iter().zip(&plain) {
                prop_assert!(old.0 < from || node == old, "{old:?} went to {node:?}");
            }
            // Nudging may leave a drop about as large as a rounding error.
            let rises = |n: &[(f32, f32)]| n[0].0 <= n[1].0 && n[0].1 <= n[1].1 + 1e-5;
            prop_assert!(nodes.windows(2).all(rises), "{nodes:?}");
        }
    }
}
