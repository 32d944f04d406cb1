//! Segments of a ray, decoded from bytes, and their truth in f64.

use gobo::reference::twin::segment::Segment;

/// Rounding error of f32: half of the last of 24 bits.
pub const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Largest number of segments per ray.
const MOST: usize = 64;

/// Bytes per segment.
const BYTES: usize = 5;

/// Decodes a depth: one of a few repeated values, any size down to the smallest float, or a float close to 1.
fn depth(code: u16) -> f32 {
    let n = code & 0x3FFF;
    match code >> 14 {
        0 => f32::from(n % 17) / 16.0,
        1 => f32::from(n) / 16383.0,
        2 => (-f32::from(n % 150)).exp2(),
        _ => 1.0 - f32::from(n) * (ROUNDING as f32),
    }
}

/// Decodes an optical depth: zero, 10⁻³⁸, and from 2⁻¹⁶ to 80, the most that a segment can have.
fn optical_depth(code: u8) -> f32 {
    match code {
        0 => 0.0,
        1 => 1e-38,
        _ => ((f32::from(code) - 128.0) / 8.0).exp2().min(80.0),
    }
}

/// Decodes consecutive entries, exits and optical depths.
pub fn segments(bytes: &[u8]) -> Vec<Segment> {
    let segment = |b: &[u8]| {
        let entry = depth(u16::from_le_bytes([b[0], b[1]]));
        let exit = depth(u16::from_le_bytes([b[2], b[3]])).max(entry);
        Segment { entry, exit, optical_depth: optical_depth(b[4]) }
    };
    bytes.chunks_exact(BYTES).take(MOST).map(segment).collect()
}

/// Returns the optical depth in front of `depth`, including a step exactly at it, from the definition: the sum of each segment's share.
pub fn truth(segments: &[Segment], depth: f32) -> f64 {
    let [depth, mut sum] = [f64::from(depth), 0.0];
    for s in segments {
        let (entry, exit) = (f64::from(s.entry), f64::from(s.exit));
        let share = if depth >= exit { 1.0 } else { ((depth - entry) / (exit - entry)).max(0.0) };
        sum += f64::from(s.optical_depth) * share;
    }
    sum
}

/// Returns the total optical depth.
pub fn total(segments: &[Segment]) -> f64 {
    segments.iter().map(|s| f64::from(s.optical_depth)).sum()
}

/// Returns ascending depths to look up: at the ends of segments, between and next to them, and in even steps.
pub fn depths(segments: &[Segment]) -> Vec<f32> {
    let mut depths: Vec<f32> = segments.iter().flat_map(|s| [s.entry, s.exit]).collect();
    depths.extend((0..=32).map(|i| i as f32 / 32.0));
    depths.sort_by(f32::total_cmp);
    let between: Vec<f32> = depths.windows(2).flat_map(|d| [0.5 * (d[0] + d[1]), d[1].next_down()]).collect();
    depths.extend(between.into_iter().filter(|depth| *depth >= 0.0));
    depths.push(2.0);
    depths.sort_by(f32::total_cmp);
    depths
}
