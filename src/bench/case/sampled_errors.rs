//! A technique's answers at the points of the truth, from which a row's errors and flicker follow.

use crate::Result;
use crate::bench::case::truth::{LIMIT_NODES, MapsTruth};
use crate::bench::error::color::ColorAnswers;
use crate::bench::error::seen::SeenAnswers;
use crate::bench::{Answers, ImageError, Row, RowError};
use crate::reference::truth::MAP_DEPTHS;
use std::sync::Arc;

/// Number of frames of a moving world at which errors are measured: evenly spread, including the first and the last.
const MOMENTS: usize = 5;

/// Returns the frames, of `frames`, at which errors are measured.
pub(in crate::bench) fn moments(frames: usize) -> Vec<usize> {
    let count = frames.min(MOMENTS);
    (0..count).map(|i| i * (frames - 1) / (count - 1).max(1)).collect()
}

/// Answers at all kinds of points, over all moments.
#[derive(Default)]
pub(in crate::bench) struct SampledErrors {
    pub(in crate::bench) map: Answers,
    pub(in crate::bench) space: Answers,
    pub(in crate::bench) surface: Answers,
    pub(in crate::bench) colors: ColorAnswers,
    pub(in crate::bench) seen: SeenAnswers,
    pub(in crate::bench) maps: Vec<Arc<MapsTruth>>,
    /// Frame-to-frame changes in the answers that do not occur in the truth; `None` if nothing moves.
    pub(in crate::bench) flicker_rms: Option<f64>,
}

impl SampledErrors {
    /// Writes the counts of the map points, and the figures that qualify the map error, into `row`. `nodes` is the number of nodes of the
    /// technique's curves, if it has curves.
    pub(in crate::bench) fn count_map(&self, nodes: Option<u32>, row: &mut Row) {
        let Some(first) = self.maps.first() else { return };
        let n = self.maps.len() as f64;
        let limit = LIMIT_NODES.iter().position(|k| Some(*k as u32) == nodes);
        let limits: Option<Vec<f64>> = self.maps.iter().map(|m| Some(m.limits.as_ref()?[limit?])).collect();
        row.limit_mean_abs = limits.filter(|_| first.covered > 0).map(|all| all.iter().sum::<f64>() / n);
        let share = self.maps.iter().map(|m| m.share).sum::<f64>() / n;
        if share < 1.0 {
            row.standard_error = self.map.standard_error(MAP_DEPTHS as usize, share);
        } else if self.maps.len() == 1 {
            row.counters.insert("reference_covered_texels".into(), first.covered);
            row.counters.insert("reference_fragments".into(), first.segments);
        }
    }

    /// Returns the errors of a row; `image` is the error of its picture.
    pub(in crate::bench) fn row_error(&self, image: Option<ImageError>) -> Result<RowError> {
        let (map, space, surface) = (self.map.error()?, self.space.error()?, self.surface.error()?);
        let seen = self.seen.error();
        Ok(RowError { seen, map, space, surface, casters: self.surface.caster_error(), image })
    }
}
