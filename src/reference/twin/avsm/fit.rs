//! CPU twin of glsl/avsm/fit.glsl: nodes moved to where the sums in cells want them, in f32.

use super::cells::{CELLS, Cells};

const REACH: f32 = 0.5;
const DIM: f32 = 1e-7;
const STRAIGHT: f32 = 1e-10;

impl Cells {
    /// So many rounds over all nodes (depth, optical depth). Twin: fit.
    pub(super) fn fit(&self, nodes: &mut [(f32, f32)], rounds: usize) {
        for parity in (0..rounds).flat_map(|_| [1, 0]) {
            for i in (parity..nodes.len()).step_by(2) {
                nodes[i] = self.fitted(nodes, i);
            }
        }
    }

    /// Twin: fitted.
    fn fitted(&self, nodes: &[(f32, f32)], i: usize) -> (f32, f32) {
        let node = nodes[i];
        let (is_first, is_last) = (i == 0, i + 1 == nodes.len());
        let dark_from = self.dark.map_or(f32::INFINITY, |(from, _)| from);
        if (is_first && is_last) || node.0 >= dark_from {
            return node;
        }
        let p = if is_first { node } else { nodes[i - 1] };
        let q = if is_last { node } else { nodes[i + 1] };
        let place = |depth: f32| (depth - self.low) * self.per_cell;
        let (at_p, at, at_q) = (place(p.0), place(node.0), place(q.0));
        let (per_p, per_q) = (1.0 / (at - at_p).max(1e-6), 1.0 / (at_q - at).max(1e-6));
        let (rise_p, rise_q) = (node.1 - p.1, q.1 - node.1);
        let (slope_p, slope_q) = (rise_p * per_p, rise_q * per_q);
        let until = at_q.min(place(dark_from));
        let (mut sums_p, mut sums_q) = ([0.0f32; 2], [0.0f32; 2]);
        for cell in at_p as usize..CELLS {
            let end = (cell + 1) as f32;
            if end > until {
                break;
            }
            let before = end <= at;
            let share = if before { (end - at_p) * per_p } else { (at_q - end) * per_q };
            let line = if before { p.1 + rise_p * share } else { q.1 - rise_q * share };
            let optical_depth = self.optical_depth(cell);
            let weight = (-2.0 * optical_depth).exp() * share;
            let sums = if before { &mut sums_p } else { &mut sums_q };
            sums[0] += weight * share;
            sums[1] += weight * (optical_depth - line);
        }
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
