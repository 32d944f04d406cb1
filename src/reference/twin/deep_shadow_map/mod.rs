//! CPU twin of glsl/technique/deep_shadow_map/: a texel's exact curve, summed in integers, and its compression. Source: Lokovic and Veach
//! 2000; the integer sums are ours.

mod area;
mod bound;

use self::area::Window;
use self::bound::{Lines, RISE, dark_from};
use super::segment::Segment;
use super::sums::DARK;

/// Number of depth steps in the light's range. Twin: DEPTH_STEPS.
const DEPTH_STEPS: f32 = 16_777_216.0;

/// Number of bits that a texel's optical depth uses of a 64-bit integer; the remaining two bits are headroom for rounding. Twin: SUM_BITS.
const SUM_BITS: i32 = 62;

/// Returns the start and end of each segment, sorted by depth. An event's `entry` is the depth at which it happens, and its `exit` the
/// depth of the segment's other end. Twin: events.comp.
pub fn events(segments: &[Segment]) -> Vec<Segment> {
    let ends = |s: &Segment| {
        if s.optical_depth <= 0.0 {
            return Vec::new();
        }
        let end = Segment { entry: s.exit, exit: s.entry, ..*s };
        if s.exit > s.entry { vec![*s, end] } else { vec![*s] }
    };
    let mut events: Vec<_> = segments.iter().flat_map(ends).collect();
    let key = |a: f32, b: f32| a.total_cmp(&b);
    events.sort_by(|a, b| {
        let ties = key(a.exit, b.exit).then_with(|| key(a.optical_depth, b.optical_depth));
        key(a.entry, b.entry).then(ties)
    });
    events
}

/// Criterion by which nodes are left out. Twin: BY_AREA.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Removal {
    /// Removes nodes if the lines stay within the error bound without them.
    Bound,
    /// Removes nodes if this changes the area under the curve by at most 4 times the square of the error.
    Area,
}

/// Returns the nodes (depth, optical depth) of a texel in order of increasing depth; two at the same depth are a step. In front of the
/// first node all light is left; behind the last, optical depth stays constant.
pub fn nodes(segments: &[Segment], removal: Removal, error: f32) -> Vec<(f32, f32)> {
    let events = events(segments);
    match removal {
        Removal::Bound => {
            let mut lines = Lines::new(error, total(&events));
            sweep(&events, |depth, value, is_last| lines.point(depth, value, is_last), dark_from(error));
            lines.nodes()
        }
        Removal::Area => {
            let mut window = Window::new(4.0 * error * error);
            sweep(&events, |depth, value, _| window.point((depth, value)), 0.0);
            window.nodes()
        }
    }
}

/// Returns the transmittance at `depth`. Twin: texel_transmittance in visibility.glsl.
pub fn transmittance(nodes: &[(f32, f32)], depth: f32) -> f32 {
    let before = nodes.partition_point(|node| node.0 <= depth);
    if before == 0 {
        return 1.0;
    }
    let (near, far) = (nodes[before - 1], nodes[before.min(nodes.len() - 1)]);
    let along = if far.0 > near.0 { ((depth - near.0) / (far.0 - near.0)).clamp(0.0, 1.0) } else { 0.0 };
    (-(near.1 * (1.0 - along) + far.1 * along)).exp()
}

/// Returns the optical depth of all segments; only the event at a segment's start counts.
fn total(events: &[Segment]) -> f32 {
    events.iter().filter(|e| e.exit >= e.entry).map(|e| e.optical_depth).sum()
}

fn steps(depth: f32) -> u32 {
    (depth.clamp(0.0, 1.0) * DEPTH_STEPS) as u32
}

/// Sweeps along the curve, summing in integers, and passes its points to `point`: depth, optical depth, and whether it is the last.
/// Twin: sweep.
///
/// Long rises get intermediate points, up to an optical depth of `dark`.
fn sweep(events: &[Segment], mut point: impl FnMut(f32, f32, bool), dark: f32) {
    if events.is_empty() {
        return;
    }
    // Number of bits for the integer part of the largest sum, which is taken as at least 1.
    let whole_bits = (total(events).max(1.0).to_bits() >> 23) as i32 - 127 + 2;
    let (scale, unit) = (2f32.powi(SUM_BITS - whole_bits), 2f32.powi(whole_bits - SUM_BITS));
    let optical_depth = |sum: u64| ((sum >> 32) as f32 * 4_294_967_296.0 + (sum & 0xFFFF_FFFF) as f32) * unit;
    let (mut value, mut rate, mut at, mut after) = (0u64, 0u64, steps(events[0].entry), 0.0);
    point(at as f32 / DEPTH_STEPS, 0.0, false);
    for event in events {
        let here = steps(event.entry);
        if here > at {
            let (depth, before) = (at as f32 / DEPTH_STEPS, optical_depth(value));
            if before != after {
                point(depth, before, false);
            }
            if before >= DARK {
                break;
            }
            value = value.wrapping_add(rate.wrapping_mul(u64::from(here - at)));
            let end = here as f32 / DEPTH_STEPS;
            after = optical_depth(value);
            let top = after.min(dark).max(before);
            let pieces = ((top - before) / RISE).ceil().max(1.0);
            let along = (end - depth) * ((top - before) / (after - before).max(1e-30)) / pieces;
            let count = if after > dark && top > before { pieces } else { pieces - 1.0 };
            for i in 1..=count as u32 {
                point(depth + i as f32 * along, before + i as f32 * ((top - before) / pieces), false);
            }
            point(end, after, false);
            at = here;
        }
        let (other, takes) = (steps(event.exit), event.optical_depth * scale);
        if other > here {
            rate = rate.wrapping_add((takes / (other - here) as f32) as u64);
        } else if other < here {
            let length = here - other;
            let its = (takes / length as f32) as u64;
            rate = rate.wrapping_sub(its);
            value = value.wrapping_add((takes as u64).wrapping_sub(its.wrapping_mul(u64::from(length))));
        } else if event.exit >= event.entry {
            value = value.wrapping_add(takes as u64);
        }
    }
    point(at as f32 / DEPTH_STEPS, optical_depth(value), true);
}
