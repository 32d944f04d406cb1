//! CPU twin of glsl/avsm/curve.glsl and of the look-up in one texel, in f32.

use super::list::Segment;

/// Twin: EMPTY.
pub const EMPTY: f32 = 3e38;

/// Twin: EXPONENTIAL. What the nodes hold and how it is interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Transmittance, linearly: the seed's.
    Linear,
    /// Optical depth, linearly.
    Exponential,
}

/// A curve of K nodes (depth, value) with room for two more, as glsl/avsm/curve.glsl has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    interpolation: Interpolation,
    depths: Vec<f32>,
    values: Vec<f32>,
    /// Smallest relative gap between the cheapest and the second cheapest removal so far. Where it is tiny, a device
    /// that rounds differently may rightly remove another node.
    pub margin: f32,
}

impl Curve {
    /// An unshadowed curve of `nodes` nodes.
    pub fn new(nodes: usize, interpolation: Interpolation) -> Self {
        let unshadowed = match interpolation {
            Interpolation::Linear => 1.0,
            Interpolation::Exponential => 0.0,
        };
        Self {
            interpolation,
            depths: vec![EMPTY; nodes + 2],
            values: vec![unshadowed; nodes + 2],
            margin: f32::INFINITY,
        }
    }

    /// The nodes (depth, value); unused ones have depth [`EMPTY`].
    pub fn nodes(&self) -> impl Iterator<Item = (f32, f32)> {
        self.depths.iter().copied().zip(self.values.iter().copied()).take(self.depths.len() - 2)
    }

    fn unshadowed(&self) -> f32 {
        match self.interpolation {
            Interpolation::Linear => 1.0,
            Interpolation::Exponential => 0.0,
        }
    }

    fn value(&self, depth: f32) -> f32 {
        let mut value = self.unshadowed();
        for i in 0..self.depths.len() - 2 {
            let (low, high) = (self.depths[i], self.depths[i + 1]);
            if low <= depth && depth < high {
                value = mix(self.values[i], self.values[i + 1], (depth - low) / (high - low));
            }
        }
        value
    }

    /// Transmittance at `depth`. Twin: texel_transmittance in glsl/avsm/visibility.glsl.
    pub fn transmittance(&self, depth: f32) -> f32 {
        match self.interpolation {
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
        let k = self.depths.len() - 2;
        let value_entry = self.value(entry);
        let mut value_exit = self.value(exit);
        match self.interpolation {
            Interpolation::Exponential => value_exit += optical_depth,
            Interpolation::Linear => value_exit *= (-optical_depth).exp(),
        }
        for (depth, value) in self.depths[..k].iter().zip(&mut self.values) {
            let ramp = if *depth <= entry {
                0.0
            } else if *depth >= exit {
                1.0
            } else {
                (depth - entry) / (exit - entry)
            };
            match self.interpolation {
                Interpolation::Exponential => *value += optical_depth * ramp,
                Interpolation::Linear => *value *= (-optical_depth * ramp).exp(),
            }
        }
        let at_entry = self.depths[..k].iter().filter(|d| **d <= entry).count();
        let at_exit = 1 + self.depths[..k].iter().filter(|d| **d <= exit).count();
        self.depths.truncate(k);
        self.values.truncate(k);
        self.depths.insert(at_entry, entry);
        self.values.insert(at_entry, value_entry);
        self.depths.insert(at_exit, exit);
        self.values.insert(at_exit, value_exit);
        self.remove_cheapest(k + 1);
        self.remove_cheapest(k);
        for i in k..k + 2 {
            self.depths[i] = EMPTY;
            self.values[i] = self.values[k - 1];
        }
    }

    fn remove_cheapest(&mut self, last: usize) {
        if self.depths[last] >= EMPTY {
            return;
        }
        let costs: Vec<f32> = (1..last).map(|i| self.removal_cost(i)).collect();
        let mut cheapest = 0;
        for (i, cost) in costs.iter().enumerate() {
            if *cost < costs[cheapest] {
                cheapest = i;
            }
        }
        let second =
            costs.iter().enumerate().filter(|(i, _)| *i != cheapest).map(|(_, c)| *c).fold(f32::INFINITY, f32::min);
        // Relative to the area of the whole range, 1: two removals that cost next to nothing are no choice either.
        self.margin = self.margin.min((second - costs[cheapest]) / second.max(1e-5));
        let gone = cheapest + 1;
        self.depths.remove(gone);
        self.values.remove(gone);
        self.depths.insert(last, EMPTY);
        self.values.insert(last, self.values[last - 1]);
    }

    fn removal_cost(&self, i: usize) -> f32 {
        let [d0, d1, d2] = [self.depths[i - 1], self.depths[i], self.depths[i + 1]];
        let [v0, v1, v2] = [self.values[i - 1], self.values[i], self.values[i + 1]];
        match self.interpolation {
            Interpolation::Exponential => {
                (span_integral(d0, v0, d1, v1) + span_integral(d1, v1, d2, v2) - span_integral(d0, v0, d2, v2)).abs()
            }
            Interpolation::Linear => 0.5 * ((d1 - d0) * (v2 - v0) - (d2 - d0) * (v1 - v0)).abs(),
        }
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

fn mean_transmittance(rise: f32) -> f32 {
    if rise < 0.02 { 1.0 - rise * (0.5 - rise * (1.0 / 6.0 - rise / 24.0)) } else { (1.0 - (-rise).exp()) / rise }
}

fn span_integral(depth_0: f32, value_0: f32, depth_1: f32, value_1: f32) -> f32 {
    (depth_1 - depth_0) * (-value_0).exp() * mean_transmittance(value_1 - value_0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn segments() -> impl Strategy<Value = Vec<Segment>> {
        // Coarse depths make equal entries, nested and zero-length segments common; some segments are opaque.
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
        fn invariants(list in segments(), nodes in prop::sample::select(vec![4usize, 8, 16]), linear: bool) {
            let interpolation = if linear { Interpolation::Linear } else { Interpolation::Exponential };
            let mut curve = Curve::new(nodes, interpolation);
            let mut total = 0.0f64;
            for s in &list {
                curve.insert(*s);
                total += f64::from(s.optical_depth);
            }
            let mut last = 1.0f32;
            for i in 0..=64 {
                let t = curve.transmittance(i as f32 / 32.0);
                prop_assert!((0.0..=1.0).contains(&t), "{t}");
                prop_assert!(t <= last + 1e-6, "rises with depth");
                last = t;
            }
            // The tail is the product of all segments, to the rounding of 60 multiplications.
            prop_assert!((f64::from(last) - (-total).exp()).abs() < 1e-5, "{last} is not {}", (-total).exp());
        }

        /// With room for every node nothing is removed, and the curve is exact at its own interpolation.
        #[test]
        fn exact_while_there_is_room(list in segments()) {
            let list = &list[..list.len().min(8)];
            let mut curve = Curve::new(16, Interpolation::Exponential);
            list.iter().for_each(|s| curve.insert(*s));
            let as_f64 = |s: &Segment| (f64::from(s.entry), f64::from(s.exit), f64::from(s.optical_depth));
            let truth = super::super::TrueCurve::new(&list.iter().map(as_f64).collect::<Vec<_>>());
            for i in 0..=100 {
                let depth = i as f32 / 100.0;
                let t = curve.transmittance(depth);
                prop_assert!((f64::from(t) - truth.transmittance(depth.into())).abs() < 1e-5, "at {depth}: {t}");
            }
        }
    }
}
