//! CPU twin of glsl/maps/curve/curve.glsl and of the look-up in one texel, in f32. Source: Salvi et al. 2010, the streaming compression,
//! and Intel's sample of 2013, "Compression stage"; nudging and the removable first node are ours.

use super::cells::CELLS;
use super::fit::Ends;
use super::node::Interpolation;
use crate::reference::twin::segment::Segment;
use crate::reference::twin::sums::DARK;

/// How a curve is built. Twin: the specialization constants of glsl/maps/curve/curve.glsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Build {
    /// NODES: number of nodes stored.
    pub nodes: usize,
    /// WORK: maximum number of nodes while segments are inserted, ≥ `nodes`.
    pub work: usize,
    /// EXPONENTIAL: whether nodes hold optical depth or transmittance.
    pub interpolation: Interpolation,
    /// NUDGE: a removal moves neighbouring nodes to keep the area under the curve, and may remove the first node too.
    pub nudge: bool,
    /// TURNS: number of refinement passes that move nodes to fit the sums in cells; passes alternate between odd and even nodes.
    pub turns: usize,
}

/// A transmittance curve, as glsl/maps/curve/curve.glsl builds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub(super) build: Build,
    /// Nodes (depth, value), in order of increasing depth.
    pub(super) nodes: Vec<(f32, f32)>,
    /// Smallest gap in cost so far between the cheapest removal and the next cheapest, as a share of the cost. If it is tiny, a device that
    /// rounds differently may correctly remove the other node.
    pub margin: f32,
}

impl Curve {
    /// Creates an unshadowed curve.
    pub fn new(build: Build) -> Self {
        Self { build, nodes: Vec::new(), margin: f32::INFINITY }
    }

    /// Returns the nodes (depth, value) in use, in order of increasing depth.
    pub fn nodes(&self) -> &[(f32, f32)] {
        &self.nodes
    }

    fn unshadowed(&self) -> f32 {
        match self.build.interpolation {
            Interpolation::Linear => 1.0,
            Interpolation::Exponential => 0.0,
        }
    }

    /// Twin: curve_value.
    fn value(&self, depth: f32) -> f32 {
        let mut value = self.unshadowed();
        for (i, &(low, v0)) in self.nodes.iter().enumerate() {
            if low <= depth {
                value = match self.nodes.get(i + 1) {
                    Some(&(high, v1)) if high > low => mix(v0, v1, ((depth - low) / (high - low)).min(1.0)),
                    _ => v0,
                };
            }
        }
        value
    }

    /// Returns the transmittance at `depth`. Twin: texel_transmittance in glsl/maps/curve/look_up.glsl.
    pub fn transmittance(&self, depth: f32) -> f32 {
        match self.build.interpolation {
            Interpolation::Linear => self.value(depth),
            Interpolation::Exponential => (-self.value(depth)).exp(),
        }
    }

    /// Twin: curve_insert.
    pub fn insert(&mut self, segment: Segment) {
        let Segment { entry, exit, optical_depth } = segment;
        if optical_depth.is_nan() || optical_depth <= 0.0 || entry.is_nan() || exit.is_nan() || entry > exit {
            return;
        }
        let value_entry = self.value(entry);
        let dark = match self.build.interpolation {
            Interpolation::Exponential => value_entry >= DARK,
            Interpolation::Linear => value_entry <= (-DARK).exp(),
        };
        if dark {
            return;
        }
        let mut value_exit = self.value(exit);
        match self.build.interpolation {
            Interpolation::Exponential => value_exit += optical_depth,
            Interpolation::Linear => value_exit *= (-optical_depth).exp(),
        }
        for (depth, value) in &mut self.nodes {
            let ramp = if *depth <= entry {
                0.0
            } else if *depth >= exit {
                1.0
            } else {
                (*depth - entry) / (exit - entry)
            };
            match self.build.interpolation {
                Interpolation::Exponential => *value += optical_depth * ramp,
                Interpolation::Linear => *value *= (-optical_depth * ramp).exp(),
            }
        }
        let at_entry = self.nodes.iter().filter(|n| n.0 <= entry).count();
        let at_exit = 1 + self.nodes.iter().filter(|n| n.0 <= exit).count();
        self.nodes.insert(at_entry, (entry, value_entry));
        self.nodes.insert(at_exit, (exit, value_exit));
        self.shrink(self.build.work);
    }

    /// Twin: curve_append.
    pub fn append(&mut self, depth: f32, optical_depth: f32) {
        let value = match self.build.interpolation {
            Interpolation::Exponential => optical_depth,
            Interpolation::Linear => (-optical_depth).exp(),
        };
        self.nodes.push((depth, value));
        self.shrink(self.build.work);
    }

    /// Twin: curve_reduce.
    pub fn reduce(&mut self) {
        self.shrink(self.build.nodes);
    }

    /// Twin: curve_reduce_refined.
    pub fn reduce_refined(&mut self) {
        let (Some(first), Some(last)) = (self.nodes.first().copied(), self.nodes.last().copied()) else { return };
        let dark = self.nodes.windows(2).find(|pair| pair[1].1 - pair[0].1 >= DARK);
        let high = dark.map_or(last.0, |pair| pair[1].0);
        let dark_from = dark.map_or(f32::INFINITY, |pair| pair[0].0);
        let per_cell = CELLS as f32 / (high - first.0).max(1e-6);
        let end = |cell: usize| first.0 + (cell + 1) as f32 / per_cell;
        let optical_depth = std::array::from_fn(|cell| self.value(end(cell)));
        self.reduce();
        Ends { low: first.0, per_cell, dark_from, optical_depth }.fit(&mut self.nodes, self.build.turns);
    }

    fn shrink(&mut self, count: usize) {
        while self.nodes.len() > count {
            self.remove_cheapest();
        }
    }

    /// Twin: remove_cheapest.
    fn remove_cheapest(&mut self) {
        let nudged = self.build.interpolation == Interpolation::Exponential && self.build.nudge;
        let spans: Vec<Span> = self.nodes.windows(2).map(|n| self.span(n[0], n[1])).collect();
        let first = usize::from(!nudged);
        let cost =
            |i: usize| if i == 0 { spans[0].extent - spans[0].area() } else { self.removal_change(i, &spans).abs() };
        let costs: Vec<f32> = (first..spans.len()).map(cost).collect();
        let mut cheapest = 0;
        for (i, cost) in costs.iter().enumerate() {
            if *cost < costs[cheapest] {
                cheapest = i;
            }
        }
        let others = costs.iter().enumerate().filter(|(i, _)| *i != cheapest).map(|(_, c)| *c);
        let second = others.fold(f32::INFINITY, f32::min);
        // Relative to at least 1e-5 of the whole range's area: if two removals both cost almost nothing, either choice is correct.
        self.margin = self.margin.min((second - costs[cheapest]) / second.max(1e-5));
        let gone = first + cheapest;
        match (nudged, gone) {
            (false, _) => {}
            (true, 0) => self.nodes[1].0 = self.nodes[0].0 + spans[0].extent * share(&spans[0], &spans[1]),
            (true, i) => self.nudge(i, &spans, self.removal_change(i, &spans)),
        }
        self.nodes.remove(gone);
    }

    /// Returns how much the area under the curve grows when node `i`, which is not the first, is removed. Twin: remove_cheapest.
    fn removal_change(&self, i: usize, spans: &[Span]) -> f32 {
        let (before, behind) = (&spans[i - 1], &spans[i]);
        let triangle = 0.5 * (behind.extent * before.rise - before.extent * behind.rise);
        if self.by_triangles() {
            return 0.5 * (before.mean + behind.mean) * triangle;
        }
        match self.build.interpolation {
            Interpolation::Exponential => {
                self.span(self.nodes[i - 1], self.nodes[i + 1]).area() - (before.area() + behind.area())
            }
            Interpolation::Linear => triangle,
        }
    }

    /// Twin: by_triangles.
    fn by_triangles(&self) -> bool {
        let Build { nodes, work, interpolation, nudge, .. } = self.build;
        interpolation == Interpolation::Exponential && nudge && work == nodes
    }

    fn span(&self, from: (f32, f32), to: (f32, f32)) -> Span {
        let (extent, rise) = (to.0 - from.0, to.1 - from.1);
        let (start, end) = ((-from.1).exp(), (-to.1).exp());
        let mean = if self.by_triangles() { 0.5 * (start + end) } else { span_mean(start, end, rise) };
        Span { extent, rise, mean }
    }

    /// Moves the neighbours of node `gone` to make up for the `change` of area caused by its removal. Twin: remove_cheapest.
    fn nudge(&mut self, gone: usize, spans: &[Span], change: f32) {
        let span = |i: Option<usize>| i.and_then(|i| spans.get(i));
        let (p, q) = (span(gone.checked_sub(2)), span(Some(gone + 1)));
        let both = spans[gone - 1].rise + spans[gone].rise;
        let area = |span: Option<&Span>| span.map_or(0.0, Span::area);
        let weight = 0.5 * area(p) + spans[gone - 1].area() + spans[gone].area() + 0.5 * area(q);
        if weight <= 1e-12 {
            return;
        }
        let (low, high) = (p.map_or(-both, |p| -p.rise), q.map_or(both, |q| q.rise));
        let shift = (change / weight).max(low).min(high);
        if p.is_some() {
            self.nodes[gone - 1].1 += shift;
        }
        if q.is_some() {
            self.nodes[gone + 1].1 += shift;
        }
    }
}

/// When the first node is removed, the second node moves towards its position. Returns how far behind that position the second node ends
/// up, as a share of the first span. Twin: remove_cheapest.
fn share(first: &Span, second: &Span) -> f32 {
    if second.mean < 0.999 { ((first.mean - second.mean) / (1.0 - second.mean)).clamp(0.0, 1.0) } else { 1.0 }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// The span between two nodes of optical depth.
struct Span {
    extent: f32,
    rise: f32,
    /// Mean transmittance.
    mean: f32,
}

impl Span {
    fn area(&self) -> f32 {
        self.extent * self.mean
    }
}

/// Twin: span_mean.
fn span_mean(start: f32, end: f32, rise: f32) -> f32 {
    let square = rise * rise;
    if rise < 0.25 {
        0.5 * (start + end) * (1.0 - square * (1.0 / 12.0 - square / 120.0))
    } else {
        (start - end) / rise
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::truth::TrueCurve;
    use proptest::prelude::*;

    fn segments() -> impl Strategy<Value = Vec<Segment>> {
        // Coarse depths make equal entries, nested segments and zero-length segments common; some segments are opaque.
        let opacity = prop_oneof![0.0..2.0f32, Just(0.0), Just(80.0), Just(1e-7)];
        prop::collection::vec((0u8..=16, 0u8..=8, opacity), 0..60).prop_map(|list| {
            list.into_iter()
                .map(|(e, l, optical_depth)| {
                    let entry = f32::from(e) / 16.0;
                    Segment { entry, exit: (entry + f32::from(l) / 32.0).min(1.0), optical_depth }
                })
                .collect()
        })
    }

    proptest! {
        #[test]
        fn invariants(
            list in segments(),
            nodes in prop::sample::select(vec![4usize, 8, 16]),
            more in prop::sample::select(vec![0usize, 8, 48]),
            linear: bool,
            nudge: bool,
        ) {
            let interpolation = if linear { Interpolation::Linear } else { Interpolation::Exponential };
            let mut curve = Curve::new(Build { nodes, work: nodes + more, interpolation, nudge, turns: 0 });
            let mut total = 0.0f64;
            for s in &list {
                curve.insert(*s);
                total += f64::from(s.optical_depth);
            }
            curve.reduce();
            prop_assert!(curve.nodes().len() <= nodes);
            let mut last = 1.0f32;
            for i in 0..=64 {
                let t = curve.transmittance(i as f32 / 32.0);
                prop_assert!((0.0..=1.0).contains(&t), "{t}");
                prop_assert!(t <= last + 1e-6, "rises with depth");
                last = t;
            }
            // The tail is the product of all segments, up to the rounding of 60 multiplications.
            prop_assert!((f64::from(last) - (-total).exp()).abs() < 1e-5, "{last} is not {}", (-total).exp());
        }

        /// A segment is left out if and only if it starts where the optical depth has already reached DARK. (The capacity is large enough
        /// for all nodes.)
        #[test]
        fn nothing_goes_in_behind_the_dark(list in segments(), linear: bool, at in 0.0..1.0f32) {
            let interpolation = if linear { Interpolation::Linear } else { Interpolation::Exponential };
            let mut curve = Curve::new(Build { nodes: 8, work: 128, interpolation, nudge: true, turns: 0 });
            list.iter().for_each(|s| curve.insert(*s));
            let before = curve.clone();
            curve.insert(Segment { entry: at, exit: 1.0, optical_depth: 0.5 });
            prop_assert_eq!(curve == before, before.transmittance(at) <= (-DARK).exp());
        }

        /// With capacity for every node, nothing is removed and the curve is exact.
        #[test]
        fn exact_while_there_is_room(list in segments()) {
            let list = &list[..list.len().min(8)];
            let interpolation = Interpolation::Exponential;
            let mut curve = Curve::new(Build { nodes: 16, work: 16, interpolation, nudge: true, turns: 0 });
            list.iter().for_each(|s| curve.insert(*s));
            let as_f64 = |s: &Segment| (f64::from(s.entry), f64::from(s.exit), f64::from(s.optical_depth));
            let truth = TrueCurve::new(&list.iter().map(as_f64).collect::<Vec<_>>());
            for i in 0..=100 {
                let depth = i as f32 / 100.0;
                let t = curve.transmittance(depth);
                prop_assert!((f64::from(t) - truth.transmittance(depth.into())).abs() < 1e-5, "at {depth}: {t}");
            }
        }
    }
}
