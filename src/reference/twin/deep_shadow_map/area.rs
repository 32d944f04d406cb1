//! CPU twin of glsl/technique/deep_shadow_map/area.glsl: removes nodes whose removal hardly changes the area under the curve, as AVSM does.
//! Source: Salvi et al. 2010, the removal. The window sliding along the curve is ours, and the number of nodes is not fixed.

/// Number of nodes that may still be removed at any time. Twin: WINDOW.
const WINDOW: usize = 16;

type Node = (f32, f32);

/// A window of nodes that may still be removed, behind the nodes that stay.
pub struct Window {
    /// Largest change of area that a removal may cause.
    most: f32,
    stay: Vec<Node>,
    /// The nodes in the window. Unless `stay` is empty, the first node here is also the last one in `stay`.
    nodes: Vec<Node>,
}

impl Window {
    pub fn new(most: f32) -> Self {
        Self { most, stay: Vec::new(), nodes: Vec::new() }
    }

    /// Twin: window_point.
    pub fn point(&mut self, node: Node) {
        if self.nodes.last() == Some(&node) {
            return;
        }
        // The curve starts with a step, which needs no node in front of it.
        if self.stay.is_empty() && self.nodes.len() == 1 && self.nodes[0].0 == node.0 {
            self.nodes.clear();
        }
        self.nodes.push(node);
        if self.nodes.len() > WINDOW && !self.remove() {
            self.keep_first();
        }
    }

    /// Ends the curve and returns its nodes. Twin: window_finish.
    pub fn nodes(mut self) -> Vec<Node> {
        while self.remove() {}
        let kept = usize::from(!self.stay.is_empty());
        self.stay.extend(self.nodes.drain(..).skip(kept));
        self.stay
    }

    /// Moves the first removable node to the nodes that stay. Twin: keep_first.
    fn keep_first(&mut self) {
        if self.stay.is_empty() {
            self.stay.push(self.nodes[0]);
        }
        self.nodes.remove(0);
        self.stay.push(self.nodes[0]);
    }

    /// Removes the node whose removal changes the area least, if by at most `most`. Twin: remove_least.
    fn remove(&mut self) -> bool {
        let n = &self.nodes;
        let change = |i: usize| area(n[i - 1], n[i + 1]) - (area(n[i - 1], n[i]) + area(n[i], n[i + 1]));
        let mut least = (0, f32::INFINITY, 0.0);
        for i in 1..n.len().saturating_sub(1) {
            let change = change(i);
            if change.abs() < least.1 {
                least = (i, change.abs(), change);
            }
        }
        let (gone, cost, change) = least;
        if cost > self.most {
            return false;
        }
        self.nudge(gone, change);
        self.nodes.remove(gone);
        true
    }

    /// Moves the neighbours of a removed node to keep the area, but never the first or last node. Twin: remove_least.
    fn nudge(&mut self, gone: usize, change: f32) {
        let n = &mut self.nodes;
        let (has_before, has_behind) = (gone >= 2, gone + 2 < n.len());
        let (before, behind) = (n[gone - 1], n[gone + 1]);
        let (p, q) = (n[gone.max(2) - 2], n[(gone + 2).min(n.len() - 1)]);
        let area_p = if has_before { area(p, before) } else { 0.0 };
        let area_q = if has_behind { area(behind, q) } else { 0.0 };
        let weight = 0.5 * area_p + area(before, n[gone]) + area(n[gone], behind) + 0.5 * area_q;
        let both = behind.1 - before.1;
        let low = if has_before { p.1 - before.1 } else { -both };
        let high = if has_behind { q.1 - behind.1 } else { both };
        let shift = if weight > 1e-12 { (change / weight).max(low).min(high) } else { 0.0 };
        n[gone - 1].1 += if has_before { shift } else { 0.0 };
        n[gone + 1].1 += if has_behind { shift } else { 0.0 };
    }
}

/// Returns the area under the transmittance between two nodes. Twin: span_area.
fn area(from: Node, to: Node) -> f32 {
    let (start, end, rise) = ((-from.1).exp(), (-to.1).exp(), to.1 - from.1);
    let square = rise * rise;
    let mean = if rise < 0.25 {
        0.5 * (start + end) * (1.0 - square * (1.0 / 12.0 - square / 120.0))
    } else {
        (start - end) / rise
    };
    mean * (to.0 - from.0)
}
