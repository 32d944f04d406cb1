//! CPU twin of glsl/maps/sums/: sums over the casters on a texel's ray, in f32 and in integers.

use super::segment::{Segment, texel_segment};
use super::sums::{DARK, scale};
use crate::scene::{Caster, View};

/// The range of depths that a texel's sums cover. Twins: RANGE_SCENE and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// All depths of the map.
    Scene,
    /// Depths from the texel's front to the map's end.
    Front,
    /// Depths from the texel's front to its back.
    Texel,
}

impl Range {
    /// Returns the start and end of the range, for a texel with these segments. Twin: range_of.
    pub fn of(self, segments: &[Segment]) -> [f32; 2] {
        let front = segments.iter().map(|s| s.entry).fold(f32::INFINITY, f32::min);
        let back = segments.iter().map(|s| s.exit).fold(-f32::INFINITY, f32::max);
        let empty = segments.is_empty();
        let begin = if empty || self == Self::Scene { 0.0 } else { front };
        let end = if self != Self::Texel {
            1.0
        } else if empty {
            0.0
        } else {
            back
        };
        [begin, end]
    }
}

/// Returns a depth's position in a range, from 0 to 1. Twin: range_place.
pub fn place([begin, end]: [f32; 2], depth: f32) -> f32 {
    if depth >= end {
        1.0
    } else if depth <= begin {
        0.0
    } else {
        ((depth - begin) / (end - begin)).min(1.0)
    }
}

/// Returns the segments of a texel that absorb light, each cut off where its optical depth reaches `dark`. Twin: view_segment.
pub fn segments(view: &View, texel: [u32; 2], casters: &[Caster], dark: f32) -> Vec<Segment> {
    let all = casters.iter().filter_map(|c| texel_segment(view, texel, c)).filter(|s| s.optical_depth > 0.0);
    all.map(|s| {
        let share = (dark / s.optical_depth).min(1.0);
        Segment { exit: s.entry + (s.exit - s.entry) * share, optical_depth: s.optical_depth.min(dark), ..s }
    })
    .collect()
}

/// Returns the range of a texel and its sums. `parts` is the technique's segment_parts: it returns what a segment between two positions
/// adds to each sum. `bound` is [`super::sums::bound`] of the casters of the texel's tile. Twin: binned.glsl.
pub fn binned<const N: usize>(
    (view, texel, casters, bound): (&View, [u32; 2], &[Caster], u64),
    range: Range,
    parts: impl Fn([f32; 2], f32) -> [f32; N],
) -> ([f32; 2], [f32; N]) {
    let segments = segments(view, texel, casters, DARK);
    let (range, scale) = (range.of(&segments), scale(bound));
    let mut units = [0i32; N];
    for segment in &segments {
        let all = parts([segment.entry, segment.exit].map(|depth| place(range, depth)), segment.optical_depth);
        for (sum, part) in units.iter_mut().zip(all) {
            *sum += (part * scale + 0.5).floor() as i32;
        }
    }
    (range, units.map(|sum| sum as f32 / scale))
}

/// Like [`binned`], for casters that are drawn: sums are rounded after each caster. Twin: ends.frag, raster.glsl and their blending in 32
/// bits.
pub fn drawn<const N: usize>(
    (view, texel, casters): (&View, [u32; 2], &[Caster]),
    range: Range,
    parts: impl Fn([f32; 2], f32) -> [f32; N],
) -> ([f32; 2], [f32; N]) {
    let segments = segments(view, texel, casters, DARK);
    let (range, mut sums) = (range.of(&segments), [0.0; N]);
    for segment in &segments {
        let all = parts([segment.entry, segment.exit].map(|depth| place(range, depth)), segment.optical_depth);
        for (sum, part) in sums.iter_mut().zip(all) {
            *sum += part;
        }
    }
    (range, sums)
}

/// Number of equal cells into which a coarser level's range is divided. Twin: LEVEL_CELLS of glsl/maps/sums/even_cells.glsl.
pub const EVEN_CELLS: usize = 32;

/// A texel from which a coarser level is built: its range, and its optical depth up to a position in it.
pub type Below<'a> = ([f32; 2], &'a dyn Fn(f32) -> f32);

/// The curve of a texel in a coarser level of detail: between the ends of the equal cells of its range, optical depth rises linearly. Twin:
/// glsl/maps/sums/levels.glsl.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Depths at which the range starts and ends.
    pub range: [f32; 2],
    /// Optical depth up to the end of each cell.
    pub ends: [f32; EVEN_CELLS],
}

impl Curve {
    /// Builds the curve whose transmittance at the ends of cells is the mean of the four texels below. Texels past the map's edge and
    /// texels without casters count as unshadowed.
    pub fn merged(below: [Option<Below>; 4], of: Range) -> Self {
        let casts = below.map(|texel| texel.filter(|(_, optical_depth)| optical_depth(1.0) > 0.0));
        let all = casts.iter().flatten().map(|(range, _)| *range);
        let front = all.clone().map(|range| range[0]).fold(f32::INFINITY, f32::min);
        let back = all.map(|range| range[1]).fold(f32::NEG_INFINITY, f32::max);
        let range = match of {
            Range::Scene => [0.0, 1.0],
            _ if front > back => [0.0, if of == Range::Front { 1.0 } else { 0.0 }],
            Range::Front => [front, 1.0],
            Range::Texel => [front, back],
        };
        let (mut ends, mut last) = ([0.0; EVEN_CELLS], 0.0f32);
        for (cell, end) in ends.iter_mut().enumerate() {
            let to = (cell + 1) as f32 / EVEN_CELLS as f32;
            let depth = range[0] * (1.0 - to) + range[1] * to;
            let through = |(range, optical_depth): &Below| (-optical_depth(place(*range, depth))).exp();
            let mean = casts.iter().fold(0.0, |sum, texel| sum + 0.25 * texel.as_ref().map_or(1.0, through));
            last = last.max(if mean < 1.0 { -mean.max(1e-35).ln() } else { 0.0 });
            *end = last;
        }
        Self { range, ends }
    }

    /// Returns the optical depth up to a position in the range, from 0 to 1. The next coarser level reads this curve instead of the sums.
    pub fn optical_depth(&self, place: f32) -> f32 {
        let cell = ((place * EVEN_CELLS as f32) as usize).min(EVEN_CELLS - 1);
        let [before, end] = [cell, cell + 1].map(|k| if k == 0 { 0.0 } else { self.ends[k - 1] });
        let along = (place * EVEN_CELLS as f32 - cell as f32).clamp(0.0, 1.0);
        before * (1.0 - along) + end * along
    }

    /// Returns the sums to be stored: each cell adds one segment. `parts` is the technique's segment_parts.
    pub fn sums<const N: usize>(&self, parts: impl Fn([f32; 2], f32) -> [f32; N]) -> [f32; N] {
        let (mut last, mut sums) = (0.0, [0.0; N]);
        for (cell, end) in self.ends.into_iter().enumerate() {
            let places = [cell, cell + 1].map(|k| k as f32 / EVEN_CELLS as f32);
            for (sum, part) in sums.iter_mut().zip(parts(places, end - last)) {
                *sum += part;
            }
            last = end;
        }
        sums
    }
}
