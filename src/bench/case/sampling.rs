//! What a row asks a technique at the points of the truth, for its errors and its flicker.

use crate::Result;
use crate::bench::Answers;
use crate::bench::Row;
use crate::bench::case::SceneCase;
use crate::bench::case::points::at_once;
use crate::bench::case::truth::{LIMIT_NODES, MapsTruth, Points, Truth};
use crate::bench::error::color::ColorAnswers;
use crate::bench::error::flicker::Flicker;
use crate::bench::error::footprint::{FootprintError, footprint_errors, footprints};
use crate::bench::error::seen::SeenAnswers;
use crate::query::{PointBatch, Query};
use crate::reference::truth::MAP_DEPTHS;
use crate::scene::{Resolution, View};
use crate::technique::{Opened, Technique};
use std::sync::Arc;

/// Frames of a moving world at which errors are taken: evenly spread, the first and the last among them.
const MOMENTS: usize = 5;

/// The frames, of so many, at which errors are taken.
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
    maps: Vec<Arc<MapsTruth>>,
}

impl SceneCase<'_> {
    /// Writes the counts of the map points, and the figures that qualify the map error, into `row`.
    pub(in crate::bench) fn count(&self, asked: &SampledErrors, nodes: Option<u32>, row: &mut Row) {
        let Some(first) = asked.maps.first() else { return };
        let n = asked.maps.len() as f64;
        let limit = LIMIT_NODES.iter().position(|k| Some(*k as u32) == nodes);
        let limits: Option<Vec<f64>> = asked.maps.iter().map(|m| Some(m.limits.as_ref()?[limit?])).collect();
        row.limit_mean_abs = limits.filter(|_| first.covered > 0).map(|all| all.iter().sum::<f64>() / n);
        let share = asked.maps.iter().map(|m| m.share).sum::<f64>() / n;
        if share < 1.0 {
            row.standard_error = asked.map.standard_error(MAP_DEPTHS as usize, share);
        } else if asked.maps.len() == 1 {
            row.counters.insert("reference_covered_texels".into(), first.covered);
            row.counters.insert("reference_fragments".into(), first.segments);
        }
    }

    /// Goes through all frames once more. Asks in all of them at seen points and for flicker, which it returns, and in some of them for
    /// the other errors.
    pub(in crate::bench) fn ask_frames(
        &mut self,
        opened: &mut Opened,
        asked: &mut SampledErrors,
    ) -> Result<Option<f64>> {
        let count = self.frames.states.count();
        let moments = moments(count);
        let mut flicker = Flicker::default();
        for frame in 0..count {
            if count > 1 {
                self.show(frame)?;
                opened.build(&self.world)?;
            }
            let technique = opened.technique.as_ref();
            self.with_truth(frame, |truth| {
                if count > 1 && technique.answer().painter.is_none() {
                    let resolution = technique.inspect().resolution();
                    let watched = self.ask_all(technique, truth, truth.watched(), &resolution)?;
                    flicker.frame(watched, truth.watched(), truth.scene());
                }
                if technique.answer().painter.is_none() {
                    self.ask_seen(technique, truth, &mut asked.seen)?;
                }
                let is_wanted = moments.contains(&frame) && self.effort.truth.has_reasons();
                if is_wanted { self.ask_moment(technique, truth, asked) } else { Ok(()) }
            })?;
        }
        Ok(flicker.rms())
    }

    /// Asks for errors in one frame.
    fn ask_moment(&self, technique: &dyn Technique, truth: &Truth, asked: &mut SampledErrors) -> Result<()> {
        let resolution = technique.inspect().resolution();
        let paints = technique.answer().painter.is_some();
        if !paints {
            asked.space.extend(self.ask_all(technique, truth, truth.space(), &resolution)?);
        }
        asked.surface.extend(self.ask_all(technique, truth, truth.surface(), &resolution)?);
        self.ask_colors(technique, truth, &mut asked.colors)?;
        // A technique without maps has no map error.
        let views: Vec<View> = technique.inspect().maps().iter().map(|m| m.caster_view).collect();
        if !views.is_empty() && !paints {
            let maps = truth.maps(views);
            asked.map.extend(self.ask_all(technique, truth, &maps.maps, &resolution)?);
            asked.maps.push(maps);
        }
        Ok(())
    }

    /// Answers at points of all lights.
    fn ask_all(
        &self,
        technique: &dyn Technique,
        truth: &Truth,
        all: &[Points],
        resolution: &[Resolution],
    ) -> Result<Answers> {
        let mut answers = Answers { approximate: self.ask(technique, all)?, ..Answers::default() };
        for points in all {
            answers.truth.extend(&points.visibility);
            answers.casters.extend(&points.casters);
            answers.within.extend(truth.boundary(points, resolution).iter());
        }
        Ok(answers)
    }

    /// Errors against means over areas of each size; look-ups are told the size.
    pub(in crate::bench) fn ask_footprints(&self, technique: &dyn Technique) -> Result<Vec<FootprintError>> {
        let areas = match self.footprints.get() {
            Some(areas) => areas,
            None => {
                let made = self.with_truth(0, |truth| Ok(footprints(truth, truth.scene())))?;
                self.footprints.get_or_init(|| made)
            }
        };
        let asked: Vec<_> =
            areas.points.iter().map(|p| PointBatch { light: p.light, points: &p.positions, normals: &[] }).collect();
        let of = |sides: &Vec<f32>| Query::of_areas(self.context, &asked, sides)?.ask(&technique.answer());
        let answers: Vec<_> = areas.sides.iter().map(of).collect::<Result<_>>()?;
        Ok(footprint_errors(&answers, areas))
    }

    /// Visibility of all lights at their points, asked about a million at a time.
    pub(in crate::bench) fn ask<'a>(
        &self,
        technique: &dyn Technique,
        all: impl IntoIterator<Item = &'a Points>,
    ) -> Result<Vec<f32>> {
        let mut answers = Vec::new();
        for asked in at_once(all) {
            answers.extend(Query::of_lights(self.context, &asked)?.ask(&technique.answer())?);
        }
        Ok(answers)
    }
}
