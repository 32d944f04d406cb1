//! CPU twin of glsl/technique/avsm/cells.comp: a texel's curve from sums of optical depth in evenly spaced cells, in f32.

use super::curve::{Build, Curve};
use super::fit::Ends;
use super::node::Interpolation;
use crate::reference::twin::segment::Segment;
use crate::reference::twin::sums::{DARK, scale};

/// Number of cells of a texel. Twin: CELLS.
pub const CELLS: usize = 64;

const LEFT_OUT: f32 = 6.4e-4;
const COARSER: f32 = 2.5;
const GROUPS: i32 = 4;

/// The sums of a texel's segments.
pub struct Cells {
    /// Depth at which the first cell starts.
    pub(super) low: f32,
    pub(super) per_cell: f32,
    /// Optical depth of one unit.
    pub(super) unit: f32,
    /// Units of optical depth up to the end of each cell, excluding the segment in `dark`.
    sums: [u32; CELLS],
    /// The first segment that blocks all light: the depth at which it starts, and the depth at which no light is left.
    pub(super) dark: Option<(f32, f32)>,
}

impl Cells {
    /// Sums segments, given in any order; `None` if there are no segments. `bound` is the upper bound on optical depth in the texel's tile
    /// ([`bound`](crate::reference::twin::sums::bound)).
    pub fn new(segments: &[Segment], bound: u64) -> Option<Self> {
        if segments.is_empty() {
            return None;
        }
        let segments: Vec<_> = segments.iter().map(dark_segment).collect();
        let low = segments.iter().map(|s| s.entry).fold(f32::INFINITY, f32::min);
        let is_dark = |s: &&Segment| s.optical_depth >= DARK;
        let dark_at = segments.iter().filter(is_dark).map(|s| s.exit).reduce(f32::min);
        let high = dark_at.unwrap_or_else(|| segments.iter().map(|s| s.exit).fold(0.0, f32::max));
        let per_cell = CELLS as f32 / (high - low).max(1e-6);
        let scale = scale(bound);
        let mut changes = [0u32; CELLS];
        let mut dark: Option<(f32, f32)> = None;
        for s in &segments {
            if is_dark(&s) && s.exit == high {
                dark = Some((dark.map_or(s.entry, |(from, _)| from.min(s.entry)), high));
            } else if dark_at.is_none() || s.entry < high {
                let share = if s.exit > high { (high - s.entry) / (s.exit - s.entry) } else { 1.0 };
                let at = |depth: f32| ((depth - low) * per_cell).clamp(0.0, CELLS as f32);
                add_segment(&mut changes, at(s.entry), at(s.exit), s.optical_depth * scale * share);
            }
        }
        let mut sums = [0u32; CELLS];
        let (mut sum, mut taken) = (0u32, 0u32);
        for (sum_upto, change) in sums.iter_mut().zip(changes) {
            taken = taken.wrapping_add(change);
            sum = sum.wrapping_add(taken);
            *sum_upto = sum;
        }
        for i in (0..CELLS - 1).rev() {
            sums[i] = sums[i].min(sums[i + 1]);
        }
        Some(Self { low, per_cell, unit: 1.0 / scale, sums, dark })
    }

    /// Returns the optical depth up to the end of a cell.
    pub(super) fn optical_depth(&self, cell: usize) -> f32 {
        self.sums[cell] as f32 * self.unit
    }

    /// Returns the values to which nodes are fitted.
    pub(super) fn ends_of_cells(&self) -> Ends {
        Ends {
            low: self.low,
            per_cell: self.per_cell,
            dark_from: self.dark.map_or(f32::INFINITY, |(from, _)| from),
            optical_depth: std::array::from_fn(|cell| self.optical_depth(cell)),
        }
    }

    /// Returns a mask of the cell ends that the curve needs, one bit per cell: dropping any end outside the mask loses less area than
    /// `loss`. Twin: ends_that_stay.
    fn ends_that_stay(&self, loss: f32) -> u64 {
        let mut ends = 1 << (CELLS - 1);
        let (mut before, mut extent) = (0.0f32, 1.0);
        for i in 0..CELLS - 1 {
            let (here, next) = (self.optical_depth(i), self.optical_depth(i + 1));
            let triangle = (here - before) * (extent + 1.0) - (next - before) * extent;
            if triangle.abs() * (-before).exp() >= loss {
                ends |= 1 << i;
                before = here;
                extent = 1.0;
            } else {
                extent += 1.0;
            }
        }
        ends
    }

    /// Returns the cell ends from which the curve is built; bit i is cell i. Twin: the masks of main.
    pub fn ends(&self, build: Build) -> u64 {
        let Build { nodes, turns, .. } = build;
        let square = (nodes * nodes) as f32;
        let at = |group| self.ends_that_stay(2.0 * LEFT_OUT / square * self.per_cell * COARSER.powi(group));
        let few_enough = |ends: u64| ends.count_ones() as usize <= if turns > 0 { 3 } else { 5 } * nodes / 2;
        (0..GROUPS - 1).map(at).find(|ends| few_enough(*ends)).unwrap_or_else(|| at(GROUPS - 1))
    }

    /// Builds the curve through the cell ends that it needs, and compresses it. Twin: the rest of main.
    pub fn curve(&self, build: Build) -> Curve {
        let ends = self.ends(build);
        let mut curve = Curve::new(build);
        curve.append(self.low, 0.0);
        for end in (0..CELLS).filter(|end| ends >> end & 1 == 1) {
            let depth = self.low + (end + 1) as f32 / self.per_cell;
            if self.dark.is_none_or(|(from, _)| depth < from) {
                curve.append(depth, self.optical_depth(end));
            }
        }
        if let Some((from, at)) = self.dark {
            let place = ((from - self.low) * self.per_cell).clamp(0.0, CELLS as f32);
            let cell = (place as usize).min(CELLS - 1);
            let before = if cell > 0 { self.sums[cell - 1] as f32 } else { 0.0 };
            let units = before + (self.sums[cell] as f32 - before) * (place - cell as f32);
            curve.append(from, units * self.unit);
            curve.append(at, self.optical_depth(CELLS - 1) + DARK);
        }
        curve.reduce();
        if build.interpolation == Interpolation::Exponential {
            self.ends_of_cells().fit(&mut curve.nodes, build.turns);
        }
        curve
    }
}

/// Cuts a segment off where its optical depth reaches DARK. Twin: segment_cut.
fn dark_segment(segment: &Segment) -> Segment {
    let (entry, exit) = (segment.entry.max(0.0), segment.exit.max(0.0));
    let share = (DARK / segment.optical_depth).min(1.0);
    Segment { entry, exit: entry + (exit - entry) * share, optical_depth: segment.optical_depth.min(DARK) }
}

/// Twin: add_segment.
fn add_segment(changes: &mut [u32; CELLS], entry: f32, exit: f32, whole: f32) {
    let (first, last) = ((entry as usize).min(CELLS - 1), (exit as usize).min(CELLS - 1));
    let rate = whole / (exit - entry).max(1e-6);
    let begin = entry - first as f32;
    let (units, early) = ((whole + 0.5) as u32, (((1.0 - begin) * rate).min(whole) + 0.5) as u32);
    let even = (rate.min(whole) + begin) as u32;
    let late = early.wrapping_add(even.wrapping_mul((last - first) as u32)).wrapping_sub(units);
    let mut add = |cell: usize, units: u32| {
        if let Some(change) = changes.get_mut(cell) {
            *change = change.wrapping_add(units);
        }
    };
    add(first, early);
    add(first + 1, even.wrapping_sub(early));
    add(last, late.wrapping_neg());
    add(last + 1, late.wrapping_sub(even));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::truth::TrueCurve;
    use crate::reference::twin::sums::bound;
    use crate::scene::Caster;
    use proptest::prelude::*;

    fn segments() -> impl Strategy<Value = Vec<Segment>> {
        let opacity = prop_oneof![0.0..2.0f32, Just(0.0), Just(80.0), Just(1e-7)];
        prop::collection::vec((0.0..1.0f32, 0.0..0.4f32, opacity), 1..60).prop_map(|list| {
            list.into_iter()
                .map(|(entry, length, optical_depth)| Segment { entry, exit: (entry + length).min(1.0), optical_depth })
                .collect()
        })
    }

    /// Returns a bound for the sum over segments, treating each as a sphere of its optical depth.
    fn bound_of(segments: &[Segment]) -> u64 {
        let casters: Vec<_> = segments
            .iter()
            .map(|s| Caster { position: [0.0; 3], radius: 0.5, axis: [0.0; 3], density: s.optical_depth })
            .collect();
        bound(&casters, DARK)
    }

    proptest! {
        /// At the cell ends the sums equal the truth, and the order of the segments makes no difference.
        #[test]
        fn sums_are_exact_at_the_ends(list in segments()) {
            let cells = Cells::new(&list, bound_of(&list)).expect("some segments");
            let as_f64 = |s: &Segment| (f64::from(s.entry), f64::from(s.exit), f64::from(s.optical_depth));
            let truth = TrueCurve::new(&list.iter().map(as_f64).collect::<Vec<_>>());
            for cell in 0..CELLS {
                let end = f64::from(cells.low) + (cell + 1) as f64 / f64::from(cells.per_cell);
                let rising = |(from, at): (f32, f32)| (end - f64::from(from)) / f64::from((at - from).max(1e-7));
                let dark = f64::from(DARK) * cells.dark.map_or(0.0, rising).clamp(0.0, 1.0);
                let through = (-f64::from(cells.optical_depth(cell)) - dark).exp();
                // A cell's end is known only up to rounding, and short dense segments are steep there. Optical depth beyond 16 does not
                // matter.
                let (before, behind) = (truth.transmittance(end - 1e-6), truth.transmittance(end + 1e-6));
                prop_assert!(through <= before + 2e-5 && through >= behind - 2e-5, "{through}, not {before} to {behind}");
            }
            prop_assert!(cells.sums.is_sorted());
            let backwards: Vec<_> = list.iter().rev().copied().collect();
            prop_assert_eq!(cells.sums, Cells::new(&backwards, bound_of(&list)).expect("the same").sums);
        }

        /// Rounding errors of many segments that each add a few units to a cell partly cancel: the error of the sum grows with the square
        /// root of the number of segments.
        #[test]
        fn roundings_new_cancel(units in 1.0..20.0f32, length in 0.05..0.5f32, seed: u64) {
            const MANY: usize = 4096;
            let mut state = seed | 1;
            let mut random = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 40) as f32 / (1u64 << 24) as f32
            };
            let cells_long = length * CELLS as f32;
            // With this bound a unit is an optical depth of 2⁻¹⁶. Each segment is a whole number of units.
            let optical_depth = (units * cells_long).round() / 65536.0;
            let mut list: Vec<_> = (0..MANY)
                .map(|_| random() * (1.0 - length))
                .map(|entry| Segment { entry, exit: entry + length, optical_depth })
                .collect();
            // This segment makes the 64 cells span 0 to 1.
            list.push(Segment { entry: 0.0, exit: 1.0, optical_depth: 0.0 });
            let cells = Cells::new(&list, 1 << 22).expect("some segments");
            prop_assert_eq!(cells.unit, 1.0 / 65536.0);
            for cell in 0..CELLS {
                let end = (cell + 1) as f32 / CELLS as f32;
                let taken = |s: &Segment| f64::from(s.optical_depth) * f64::from(((end - s.entry) / length).clamp(0.0, 1.0));
                let exact: f64 = list.iter().map(taken).sum::<f64>() * 65536.0;
                // In each cell that a segment crosses, its share is rounded by at most half a unit (root mean square). `cells_long` is the
                // number of cells that a segment crosses.
                let most = 5.0 * (MANY as f64).sqrt() * f64::from(0.5 * cells_long + 1.0);
                let off = f64::from(cells.sums[cell]) - exact;
                prop_assert!(off.abs() < most, "{off} units of {exact}, not {most}");
            }
        }

        #[test]
        fn invariants(list in segments(), nodes in prop::sample::select(vec![4usize, 8, 16]), linear: bool, nudge: bool,
            turns in 0usize..5) {
            let interpolation = if linear { Interpolation::Linear } else { Interpolation::Exponential };
            let cells = Cells::new(&list, bound_of(&list)).expect("some segments");
            let curve = cells.curve(Build { nodes, work: nodes + 2, interpolation, nudge, turns });
            prop_assert!(curve.nodes().len() <= nodes);
            let mut last = 1.0f32;
            for i in 0..=64 {
                let t = curve.transmittance(i as f32 / 32.0);
                prop_assert!((0.0..=1.0).contains(&t) && t <= last + 1e-6, "{t} after {last}");
                last = t;
            }
            let total: f64 = list.iter().map(|s| f64::from(s.optical_depth)).sum();
            prop_assert!((f64::from(last) - (-total).exp()).abs() < 1e-5, "{last} is not {}", (-total).exp());
        }
    }
}
