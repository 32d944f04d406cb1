//! CPU twin of glsl/maps/curve/pack.glsl and glsl/maps/curve/store.glsl: curves packed from f32 into 16 bits of depth and 16 bits of value
//! per node. Tight curves use 8 bits for each.

use super::curve::Curve;
use super::node::{EMPTY, Interpolation};

/// Twin: LEAST_EXTENT.
const LEAST_EXTENT: f32 = 1e-30;

/// A packed curve, with one word per node of its capacity.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// Depth of the first node, or [`EMPTY`] if there is none.
    pub first: f32,
    /// Distance from the first node to the last, in depth.
    pub extent: f32,
    /// Depth code << 16 | value code.
    pub words: Vec<u32>,
}

/// Twin: pack_depth.
fn pack_depth(depth: f32, first: f32, extent: f32) -> u32 {
    if extent > LEAST_EXTENT { ((depth - first) * (65535.0 / extent) + 0.5).min(65535.0) as u32 } else { 0 }
}

/// Twin: pack_value.
pub fn pack_value(value: f32, interpolation: Interpolation) -> u32 {
    let code = match interpolation {
        Interpolation::Exponential => 65536.0 * (value / (1.0 + value)),
        Interpolation::Linear => 65535.0 * (1.0 - value),
    };
    (code + 0.5).clamp(0.0, 65535.0) as u32
}

/// Twin: unpack_value.
pub fn unpack_value(code: u32, interpolation: Interpolation) -> f32 {
    match interpolation {
        Interpolation::Exponential => code as f32 / (65536 - code) as f32,
        Interpolation::Linear => (65535 - code) as f32 / 65535.0,
    }
}

/// Packs a value into one byte, for tight curves. Twin: pack_value where TIGHT.
pub fn tight_value(value: f32, interpolation: Interpolation) -> u32 {
    let code = match interpolation {
        Interpolation::Exponential => 256.0 * (value / (1.0 + value)),
        Interpolation::Linear => 255.0 * (1.0 - value),
    };
    (code + 0.5).clamp(0.0, 255.0) as u32
}

/// Packs the nodes (depth, value) in use, in order of increasing depth, into `count` words. Twin: store_curve.
pub fn pack(nodes: &[(f32, f32)], count: usize, interpolation: Interpolation) -> Packed {
    let first = nodes.first().map_or(EMPTY, |n| n.0);
    let extent = nodes.last().map_or(0.0, |n| n.0 - first);
    let mut before = 0u32;
    let mut word = |i: usize| {
        if let Some(&(depth, value)) = nodes.get(i) {
            let depth = pack_depth(depth, first, extent).max(before >> 16);
            before = depth << 16 | pack_value(value, interpolation).max(before & 0xFFFF);
        }
        before
    };
    let words = (0..count).map(&mut word).collect();
    Packed { first, extent, words }
}

/// Returns all nodes (depth, value) of a packed curve; unused words repeat the last node. Twin: unpack_node.
pub fn unpack(packed: &Packed, interpolation: Interpolation) -> Vec<(f32, f32)> {
    let step = packed.extent * (1.0 / 65535.0);
    let node = |word: &u32| (packed.first + (word >> 16) as f32 * step, unpack_value(word & 0xFFFF, interpolation));
    packed.words.iter().map(node).collect()
}

/// Returns a curve after packing and unpacking, including the rounding of both.
pub fn packed(curve: &Curve) -> Curve {
    let interpolation = curve.build.interpolation;
    let nodes = unpack(&pack(&curve.nodes, curve.build.nodes, interpolation), interpolation);
    Curve { nodes, ..curve.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOTH: [Interpolation; 2] = [Interpolation::Linear, Interpolation::Exponential];

    /// Returns the error bound of a quantized transmittance: half a step between codes, plus a small margin for f32 rounding.
    fn half_code(interpolation: Interpolation) -> f64 {
        let steepest = if interpolation == Interpolation::Linear { 1.0 } else { 4.0 * (-1.0f64).exp() };
        0.51 * steepest / 65535.0
    }

    fn transmittance(value: f32, interpolation: Interpolation) -> f64 {
        let value = f64::from(value);
        if interpolation == Interpolation::Linear { value } else { (-value).exp() }
    }

    /// Every value code round-trips to itself, and transmittance never rises with the code.
    #[test]
    fn codes_are_their_own_round_trip() {
        for interpolation in BOTH {
            let mut last = f64::INFINITY;
            for code in 0..65536 {
                let value = unpack_value(code, interpolation);
                assert_eq!(pack_value(value, interpolation), code, "{interpolation:?} {value}");
                let through = transmittance(value, interpolation);
                assert!(through <= last, "{interpolation:?}: code {code}");
                last = through;
            }
            assert_eq!(transmittance(unpack_value(0, interpolation), interpolation), 1.0);
            assert_eq!(transmittance(unpack_value(65535, interpolation), interpolation), 0.0);
        }
        for code in 0..65536 {
            for (first, extent) in [(0.0, 1.0), (0.25, 0.5), (0.0, 1e-20)] {
                let depth = first + code as f32 * (extent * (1.0 / 65535.0));
                assert_eq!(pack_depth(depth, first, extent), code, "{first} {extent}");
            }
        }
    }

    #[test]
    fn extremes() {
        for interpolation in BOTH {
            let empty = pack(&[], 8, interpolation);
            assert!(empty.first == EMPTY && unpack(&empty, interpolation).iter().all(|n| n.0 == EMPTY));
            for depth in [0.0, 0.3, 1.0] {
                for nodes in [1, 2, 8] {
                    let value = 0.5;
                    let packed = pack(&vec![(depth, value); nodes], 8, interpolation);
                    assert_eq!(packed.extent, 0.0);
                    let close = |n: &(f32, f32)| n.0 == depth && (n.1 - value).abs() < 3e-5;
                    assert!(unpack(&packed, interpolation).iter().all(close), "{packed:?}");
                }
            }
        }
        // Optical depths without an opaque segment, with one, and with many.
        let values = [0.0, 80.0, 80.0 * 64.0, 80.0 * 10_000.0];
        let nodes: Vec<_> = (0..4).map(|i| (i as f32 / 3.0, values[i])).collect();
        let back = unpack(&pack(&nodes, 4, Interpolation::Exponential), Interpolation::Exponential);
        for (value, back) in values.iter().zip(&back) {
            // Half a quantization step at t is (1 + t)² / 131,072; the last code is 65,535.
            let value = value.min(65535.0);
            assert!((back.1 - value).abs() <= 0.6 * (1.0 + back.1.max(value)).powi(2) / 65536.0, "{value}: {}", back.1);
        }
        assert_eq!(back[0].1, 0.0);
    }

    proptest! {
        #[test]
        fn order_and_half_a_code_are_kept(
            list in prop::collection::vec((0.0..1.0f32, prop_oneof![0.0..3.0f32, Just(0.0), Just(80.0), Just(1e-4), Just(1e-7)]), 1..=16),
            from in prop_oneof![Just(0.0f32), 0.0..0.9f32],
            extent in prop_oneof![Just(0.0f32), Just(1.0), Just(1e-7), Just(1e-38), 0.0..1.0f32],
            linear: bool,
        ) {
            let interpolation = BOTH[usize::from(!linear)];
            let mut depths: Vec<f32> = list.iter().map(|n| from + extent * n.0).collect();
            depths.sort_by(f32::total_cmp);
            let mut sum = 0.0;
            let values = list.iter().map(|n| {
                sum += n.1;
                if linear { (-sum).exp() } else { sum }
            });
            let nodes: Vec<(f32, f32)> = depths.into_iter().zip(values).collect();
            let packed = pack(&nodes, 16, interpolation);
            let back = unpack(&packed, interpolation);
            prop_assert_eq!(back[0].0, nodes[0].0);
            prop_assert!(back[nodes.len() - 1..].windows(2).all(|n| n[0] == n[1]), "unused nodes repeat the last");
            for (node, back) in nodes.iter().zip(&back) {
                // Error bound: half a quantization step, plus the rounding error of the depth.
                let bound = 0.51 * f64::from(packed.extent) / 65535.0 + f64::from(f32::EPSILON) * f64::from(node.0);
                prop_assert!((f64::from(back.0) - f64::from(node.0)).abs() <= bound.max(1e-30), "{node:?} {back:?}");
                let apart = transmittance(node.1, interpolation) - transmittance(back.1, interpolation);
                prop_assert!(apart.abs() <= half_code(interpolation), "{node:?} {back:?}");
            }
            for pair in back.windows(2) {
                prop_assert!(pair[0].0 <= pair[1].0, "depths fall");
                prop_assert!(transmittance(pair[1].1, interpolation) <= transmittance(pair[0].1, interpolation), "rises");
            }
            // Packing again changes nothing, so values do not drift.
            let again = unpack(&pack(&back, 16, interpolation), interpolation);
            for (a, b) in again.iter().zip(&back) {
                prop_assert_eq!(a.1, b.1);
            }
        }
    }
}
