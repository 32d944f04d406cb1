//! AVSM's twins: curves built by insertion and from cells, their storage, and look-ups in them.

use super::segments::{ROUNDING, depths, segments, total, truth};
use gobo::reference::twin::avsm::cells::Cells;
use gobo::reference::twin::avsm::curve::{Build, Curve};
use gobo::reference::twin::avsm::node::Interpolation;
use gobo::reference::twin::avsm::pack::packed;
use gobo::reference::twin::segment::Segment;
use gobo::reference::twin::sums::{DARK, bound};
use gobo::scene::Caster;

/// Maximum of |d exp(−τ) / d ln τ|, 1/e: a relative error s in optical depth changes transmittance by at most s times this.
const MOST_SHARE: f64 = 0.367_879_441_171_442_33;

/// Reads build settings from the first byte, and segments from the rest.
fn read(bytes: &[u8]) -> Option<(Build, Vec<Segment>)> {
    let (code, rest) = bytes.split_first()?;
    let nodes = [4, 8, 16][usize::from(code % 3)];
    let work = nodes + [0, 2, 8, 48][usize::from(code / 3 % 4)];
    let interpolation = [Interpolation::Linear, Interpolation::Exponential][usize::from(code / 12 % 2)];
    let turns = usize::from(code / 48);
    Some((Build { nodes, work, interpolation, nudge: code / 24 % 2 == 1, turns }, segments(rest)))
}

/// Fuzzes curves built by insertion.
pub fn avsm(bytes: &[u8]) -> bool {
    let Some((build, segments)) = read(bytes) else { return false };
    let mut curve = Curve::new(build);
    segments.iter().for_each(|s| curve.insert(*s));
    curve.reduce();
    // Error bound: per segment, the rounding of its interpolated part in front of a depth, and of the sum (or product) that it is added to.
    let off = (3 * segments.len() + 8) as f64 * ROUNDING;
    holds(&curve, build, &segments, off);
    assert_tail(&curve, &segments, off);
    looks_up(&curve, build, &segments);
    if build.interpolation == Interpolation::Exponential && 2 * segments.len() <= build.nodes {
        is_exact(&curve, &segments);
    }
    packs(&curve, build, &segments);
    true
}

/// Fuzzes curves built from cells.
pub fn cells(bytes: &[u8]) -> bool {
    let Some((build, segments)) = read(bytes) else { return false };
    let sphere = |s: &Segment| Caster { position: [0.0; 3], radius: 0.5, axis: [0.0; 3], density: s.optical_depth };
    let bound = bound(&segments.iter().map(sphere).collect::<Vec<_>>(), DARK);
    let Some(cells) = Cells::new(&segments, bound) else { return false };
    let curve = cells.curve(build);
    // Error bound: half a unit per segment; with 64 segments, a unit is at most 2⁻²⁰. Anything darker than DARK counts as DARK.
    let off = 0.5 * segments.len() as f64 / f64::from(1 << 20) + 16.0 * ROUNDING;
    holds(&curve, build, &segments, 16.0 * ROUNDING);
    assert_tail(&curve, &segments, off + (-f64::from(DARK)).exp());
    true
}

/// Asserts what every curve must satisfy: few nodes, ascending depths, transmittance in [0, 1] that never rises by more than `off`.
fn holds(curve: &Curve, build: Build, segments: &[Segment], off: f64) {
    let nodes = curve.nodes();
    assert!(nodes.len() <= build.nodes, "{} nodes", nodes.len());
    assert!(nodes.iter().all(|n| n.0.is_finite() && n.1.is_finite()), "{nodes:?}");
    assert!(nodes.windows(2).all(|n| n[0].0 <= n[1].0), "depths fall: {nodes:?}");
    let mut last = 1.0;
    for depth in depths(segments) {
        let light = curve.transmittance(depth);
        assert!((0.0..=1.0).contains(&light), "{light} at {depth}: {nodes:?}");
        assert!(f64::from(light - last) <= off, "rises from {last} to {light} at {depth}: {nodes:?}");
        last = light;
    }
}

/// Asserts that the transmittance behind all segments is the product of theirs.
fn assert_tail(curve: &Curve, segments: &[Segment], off: f64) {
    let (light, product) = (f64::from(curve.transmittance(2.0)), (-total(segments)).exp());
    assert!((light - product).abs() <= off, "the tail is {light}, not {product}: {:?}", curve.nodes());
}

/// Compares look-ups with f64 arithmetic on the same nodes. Error bound: a quotient, two products and a sum are rounded, of optical depths
/// or of transmittances.
fn looks_up(curve: &Curve, build: Build, segments: &[Segment]) {
    let off = 8.0 * ROUNDING;
    for depth in depths(segments) {
        let exact = node_light(curve.nodes(), build.interpolation, depth);
        let light = f64::from(curve.transmittance(depth));
        assert!((light - exact).abs() <= off, "{light}, not {exact}, at {depth}: {:?}", curve.nodes());
    }
}

fn node_light(nodes: &[(f32, f32)], interpolation: Interpolation, depth: f32) -> f64 {
    let behind = nodes.iter().take_while(|n| n.0 <= depth).count();
    let wide = |n: &(f32, f32)| (f64::from(n.0), f64::from(n.1));
    let value = match (behind.checked_sub(1).map(|i| wide(&nodes[i])), nodes.get(behind).map(wide)) {
        (None, _) => None,
        (Some(low), None) => Some(low.1),
        (Some(low), Some(high)) => {
            let share = (f64::from(depth) - low.0) / (high.0 - low.0);
            Some(low.1 + (high.1 - low.1) * share)
        }
    };
    match (value, interpolation) {
        (None, _) => 1.0,
        (Some(value), Interpolation::Linear) => value,
        (Some(value), Interpolation::Exponential) => (-value).exp(),
    }
}

/// Asserts that a curve with no node removed equals the truth. Error bound: eight roundings per segment, each relative to the optical
/// depth.
fn is_exact(curve: &Curve, segments: &[Segment]) {
    let off = (8.0 * (segments.len() + 1) as f64 * MOST_SHARE + 2.0) * ROUNDING;
    for depth in depths(segments) {
        let (light, exact) = (f64::from(curve.transmittance(depth)), (-truth(segments, depth)).exp());
        assert!((light - exact).abs() <= off, "{light}, not {exact}, at {depth}: {:?}", curve.nodes());
    }
}

/// Asserts that a curve stored in 16 bits per number keeps its invariants, and its tail to within half a quantization step.
fn packs(curve: &Curve, build: Build, segments: &[Segment]) {
    let stored = packed(curve);
    // Maximum slope of transmittance as a function of the code t, for an optical depth of t / (1 − t): 4 / e.
    let steepest = if build.interpolation == Interpolation::Linear { 1.0 } else { 4.0 * MOST_SHARE };
    holds(&stored, build, segments, 16.0 * ROUNDING);
    let [light, exact] = [&stored, curve].map(|curve| f64::from(curve.transmittance(2.0)));
    // Error bound: half a quantization step, plus the rounding errors of the curve, since values are made monotonic before they are stored.
    let off = 0.51 * steepest / 65535.0 + (3 * segments.len() + 8) as f64 * ROUNDING;
    assert!((light - exact).abs() <= off, "stored as {light}, not {exact}: {:?}", curve.nodes());
}
