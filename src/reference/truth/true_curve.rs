//! The exact optical depth along one light ray. Spheres make it piecewise linear, since their extinction is constant. A strand adds a step,
//! a splat an error function, and a cell of a volume a quartic.

use super::splat::share;
use super::volume::Cubic;

/// Optical depth as a function of depth in the light's range, built from the segments of one ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrueCurve {
    /// Depths at which the slope changes, in increasing order; empty if the ray meets nothing.
    pub depths: Vec<f64>,
    /// Optical depth at each of these depths, from 0 to the total of spheres and strands.
    pub optical_depths: Vec<f64>,
    /// Splats along the ray, whose optical depth is added.
    pub smooth: Vec<Smooth>,
    /// Cells along the ray for each volume, whose optical depth is added.
    pub volumes: Vec<Vec<Cubic>>,
}

/// A Gaussian along the ray, in units of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth {
    /// Depth at which the density is highest.
    pub middle: f64,
    /// Standard deviation, in units of depth.
    pub deviation: f64,
    /// Share of the Gaussian in front of the start of the light's rays.
    pub before: f64,
    /// Optical depth of the whole Gaussian.
    pub whole: f64,
}

impl TrueCurve {
    /// Builds a curve from segments (entry, exit, optical depth) in any order. A segment of length zero is a step: two vertices at the same
    /// depth.
    pub fn new(segments: &[(f64, f64, f64)]) -> Self {
        // An event is a depth, a change of slope there, and a step there.
        let mut events: Vec<(f64, f64, f64)> = Vec::with_capacity(2 * segments.len());
        for &(entry, exit, optical_depth) in segments {
            if exit > entry {
                let slope = optical_depth / (exit - entry);
                events.push((entry, slope, 0.0));
                events.push((exit, -slope, 0.0));
            } else {
                events.push((entry, 0.0, optical_depth));
            }
        }
        events.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut curve = Self::default();
        let (mut slope, mut total) = (0.0, 0.0);
        let mut i = 0;
        while i < events.len() {
            let depth = events[i].0;
            if let Some(&last) = curve.depths.last() {
                total += f64::max(slope, 0.0) * (depth - last);
            }
            let (mut step, mut open) = (0.0, false);
            while i < events.len() && events[i].0 == depth {
                slope += events[i].1;
                step += events[i].2;
                open |= events[i].1 > 0.0;
                i += 1;
            }
            // With no segment open, the slope is 0 up to rounding.
            if !open && slope < 1e-12 * total.max(1e-300) {
                slope = f64::max(slope, 0.0);
            }
            curve.push(depth, total);
            if step > 0.0 {
                total += step;
                curve.push(depth, total);
            }
        }
        curve
    }

    fn push(&mut self, depth: f64, optical_depth: f64) {
        self.depths.push(depth);
        self.optical_depths.push(optical_depth);
    }

    /// Returns the optical depth from the light to `depth`; a step exactly at `depth` counts.
    pub fn optical_depth(&self, depth: f64) -> f64 {
        let upto = |s: &Smooth| s.whole * (share((depth - s.middle) / s.deviation) - s.before).max(0.0);
        let volumes = self.volumes.iter().map(|cells| of_cells(cells, depth));
        self.piecewise(depth) + self.smooth.iter().map(upto).sum::<f64>() + volumes.sum::<f64>()
    }

    fn piecewise(&self, depth: f64) -> f64 {
        let after = self.depths.partition_point(|d| *d <= depth);
        if after == 0 {
            return 0.0;
        }
        let (d0, t0) = (self.depths[after - 1], self.optical_depths[after - 1]);
        match (self.depths.get(after), self.optical_depths.get(after)) {
            (Some(d1), Some(t1)) => t0 + (t1 - t0) * (depth - d0) / (d1 - d0),
            _ => t0,
        }
    }

    /// Returns exp(−optical depth).
    pub fn transmittance(&self, depth: f64) -> f64 {
        (-self.optical_depth(depth)).exp()
    }
}

/// Returns the optical depth up to `depth` of a volume's cells, which are given in ray order.
fn of_cells(cells: &[Cubic], depth: f64) -> f64 {
    let entered = cells.partition_point(|cell| cell.entry <= depth);
    cells[..entered].last().map_or(0.0, |cell| cell.optical_depth(depth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Generates depths, half of them multiples of 1/8, so that steps coincide with each other and with the queried depths.
    fn depths() -> impl Strategy<Value = f64> {
        prop_oneof![0.0..1.0f64, (0u8..8).prop_map(|i| f64::from(i) / 8.0)]
    }

    proptest! {
        /// Compares with the definition: the sum over all segments of optical depth × the share already passed.
        #[test]
        fn equals_the_sum_of_overlaps(
            segments in prop::collection::vec(
                (depths(), prop_oneof![0.0..0.3f64, Just(0.0)], 0.0..3.0f64),
                0..30,
            ),
            depth in prop_oneof![-0.1..1.4f64, depths()],
        ) {
            let segments: Vec<_> = segments.into_iter().map(|(e, l, t)| (e, e + l, t)).collect();
            let sum: f64 = segments
                .iter()
                .map(|&(e, x, t)| t * if depth < e { 0.0 } else if depth >= x { 1.0 } else { (depth - e) / (x - e) })
                .sum();
            let curve = TrueCurve::new(&segments);
            prop_assert!((curve.optical_depth(depth) - sum).abs() < 1e-9);
            prop_assert!(curve.optical_depths.windows(2).all(|w| w[1] >= w[0]), "optical depth never falls");
        }
    }
}
