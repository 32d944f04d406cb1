//! CPU twin of glsl/technique/deep_shadow_map/: a texel's whole curve, and the fewest nodes that stay within an error of it.
//! Source: Lokovic and Veach 2000, the greedy compression; windows in optical depth and sums in whole numbers are ours.

use super::segment::Segment;
use super::sums::DARK;

/// Steps of depth in the light's range. Twin: DEPTH_STEPS.
const DEPTH_STEPS: f32 = 16_777_216.0;

/// Bits behind the point of an optical depth in whole numbers, at most. Twin: SUM_BITS.
const SUM_BITS: u32 = 40;

/// Events that sums have room for with so many bits, as a power of two. Twin: EVENT_BITS.
const EVENT_BITS: u32 = 16;

/// A longer rise of optical depth has windows on its way too. Twin: RISE.
const RISE: f32 = 0.25;

/// Part of the error that is kept for what is between two windows. Twin: BETWEEN.
const BETWEEN: f32 = 1.0 / 64.0;

/// How exact the last node is. Twin: TAIL.
const TAIL: f32 = 1e-4;

/// Where each segment begins and where it ends, in the order of depth. An event has the depth where it happens, that of the other
/// end, and what the segment takes. Twin: events.comp.
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

/// The nodes of a texel, (depth, optical depth), depths rising; two at one depth are a step. In front of the first the light is
/// whole, behind the last it stays.
pub fn nodes(segments: &[Segment], error: f32) -> Vec<(f32, f32)> {
    let events = events(segments);
    let mut nodes = Nodes::new(error);
    sweep(&events, |depth, value, is_last| nodes.point(depth, value, is_last), error);
    nodes.all
}

/// The look-up. Twin: texel_transmittance in visibility.glsl.
pub fn transmittance(nodes: &[(f32, f32)], depth: f32) -> f32 {
    let before = nodes.partition_point(|node| node.0 <= depth);
    if before == 0 {
        return 1.0;
    }
    let (near, far) = (nodes[before - 1], nodes[before.min(nodes.len() - 1)]);
    let along = if far.0 > near.0 { ((depth - near.0) / (far.0 - near.0)).clamp(0.0, 1.0) } else { 0.0 };
    (-(near.1 * (1.0 - along) + far.1 * along)).exp()
}

fn steps(depth: f32) -> u32 {
    (depth.clamp(0.0, 1.0) * DEPTH_STEPS) as u32
}

/// Goes along the curve, whatever its length, in whole numbers, and hands over its points. Twin: sweep.
fn sweep(events: &[Segment], mut point: impl FnMut(f32, f32, bool), error: f32) {
    if events.is_empty() {
        return;
    }
    let bits = SUM_BITS - (events.len().ilog2() + 1).saturating_sub(EVENT_BITS);
    let (scale, unit) = ((bits as f32).exp2(), (-(bits as f32)).exp2());
    let optical_depth = |sum: u64| ((sum >> 32) as f32 * 4_294_967_296.0 + (sum & 0xFFFF_FFFF) as f32) * unit;
    let dark = dark_from(error);
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
            // What is darker than `dark` needs no windows on its way.
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

/// Where all is so dark that lines err by nothing. Twin: dark_from.
fn dark_from(error: f32) -> f32 {
    5.0 - (2.0 * error).ln()
}

/// The optical depths that are within `error` of this one. Twin: window.
fn window(value: f32, error: f32) -> [f32; 2] {
    let through = (-value).exp();
    let low = -(through + error).min(1.0).ln();
    // Where more than half of the light that is left is error, no more than the line that touches the bound there: it is bent, and
    // what is below it at two ends must be below it between them.
    let high = if through >= 2.0 * error {
        -(through - error).ln()
    } else {
        2.0 * value + (2.0 * error).ln() * 2.0 - error.ln()
    };
    [low.max(0.0), high]
}

/// Nodes as they come.
struct Nodes {
    error: f32,
    all: Vec<(f32, f32)>,
    /// From the last node on: the least and the greatest slope of a line that is in all windows.
    slopes: [f32; 2],
    /// The last point.
    end: (f32, f32),
}

impl Nodes {
    fn new(error: f32) -> Self {
        Self { error: error * (1.0 - BETWEEN), all: Vec::new(), slopes: [0.0, f32::MAX], end: (0.0, 0.0) }
    }

    fn start(&mut self, node: (f32, f32)) {
        self.all.push(node);
        self.slopes = [0.0, f32::MAX];
        self.end = node;
    }

    /// Ends the line at the last point, as near to it as it can. Twin: line_end.
    fn finish(&mut self) {
        let (depth, value) = self.all[self.all.len() - 1];
        let along = self.end.0 - depth;
        if along > 0.0 {
            let aim = self.end.1.clamp(value + self.slopes[0] * along, value + self.slopes[1] * along);
            self.start((self.end.0, aim));
        }
    }

    /// Twin: curve_point.
    fn point(&mut self, depth: f32, value: f32, is_last: bool) {
        let [low, high] = window(value, if is_last { self.error.min(TAIL) } else { self.error });
        if self.all.is_empty() {
            self.start((depth, value));
            return;
        }
        let from = self.all[self.all.len() - 1];
        if depth > from.0 {
            let along = depth - from.0;
            let slopes = [self.slopes[0].max((low - from.1) / along), self.slopes[1].min((high - from.1) / along)];
            if slopes[0] <= slopes[1] {
                self.slopes = slopes;
                self.end = (depth, value);
                if is_last {
                    self.finish();
                }
                return;
            }
            self.finish();
        }
        let from = self.all[self.all.len() - 1];
        if depth > from.0 {
            // A line from where the last one ended is in this window.
            let along = depth - from.0;
            self.slopes = [((low - from.1) / along).max(0.0), (high - from.1) / along];
            self.end = (depth, value);
            if is_last {
                self.finish();
            }
        } else if !(low..=high).contains(&from.1) {
            self.step(depth, value);
        }
    }

    /// A step at the depth of the last node. The first has nothing in front of it, and of several the last counts.
    fn step(&mut self, depth: f32, value: f32) {
        let count = self.all.len();
        if count == 1 || self.all[count - 2].0 == depth {
            self.all.pop();
        }
        self.start((depth, value.max(self.all.last().map_or(0.0, |node| node.1))));
    }
}
