//! One row of a comparison: build, time, ask, draw, compare with the truth.

use super::{PassTiming, PointError, Row, RowError, Status, Timing, picture_error, point_error};
use crate::consume::{Lighting, Query, Renderer, Shading};
use crate::gpu::{Context, PassTime};
use crate::reference::truth::{Casters, MapTruth, limit_mean_abs, map_truths, picture, space_points};
use crate::scene::{Picture, Scene, View};
use crate::technique::{self, Opened, Spec, Technique};
use crate::world::World;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Look-ups that are timed at once, in equal shares through each light.
pub const LOOKUPS: usize = 1_000_000;

/// Shortest warm-up.
const WARM_UP: std::time::Duration = std::time::Duration::from_millis(200);

/// When to stop timing look-ups, after one sample at least.
const LOOKUP_BUDGET: std::time::Duration = std::time::Duration::from_secs(1);

/// When to stop timing pictures, after one at least.
const DRAW_BUDGET: std::time::Duration = std::time::Duration::from_secs(1);

/// Node counts that the limit is computed for.
const LIMIT_NODES: [usize; 3] = [4, 8, 16];

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Frames that are timed.
    pub frames: usize,
    /// Frames before them that are not.
    pub warm_up: usize,
    /// Space points that are compared with the truth, for each light.
    pub space_points: usize,
    /// Size of the picture, pixels.
    pub picture: [u32; 2],
}

/// A scene with everything that its rows share.
pub struct Case<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The picture lit by the truth.
    pub reference: Picture,
    context: Context,
    world: World,
    casters: Casters<'a>,
    camera: View,
    effort: Effort,
    space: Vec<Space>,
    maps: Vec<MapsTruth>,
}

/// The truth in maps of these views, and the limits over all.
struct MapsTruth {
    views: Vec<View>,
    truths: Vec<MapTruth>,
    limits: Vec<f64>,
}

/// The space points of one light.
struct Space {
    points: Vec<[f32; 3]>,
    /// At the first of them.
    truth: Vec<f64>,
}

impl<'a> Case<'a> {
    /// Uploads `scene` and computes the truth that does not depend on a technique.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &'a Scene, effort: Effort) -> Result<Self> {
        use rayon::prelude::*;
        let casters = Casters::new(scene);
        let camera = View::camera(&scene.camera, scene, effort.picture);
        let space = |light| {
            let points = space_points(scene, light, effort.space_points.max(LOOKUPS / scene.lights.len()));
            let visibility = |p: &[f32; 3]| casters.visibility(light, glam::DVec3::from(p.map(f64::from)));
            Space { truth: points.par_iter().take(effort.space_points).map(visibility).collect(), points }
        };
        let space = (0..scene.lights.len()).map(space).collect();
        Ok(Self {
            reference: picture(&casters, scene, &camera),
            context: context.clone(),
            world: World::new(context, scene)?,
            scene,
            casters,
            camera,
            effort,
            space,
            maps: Vec::new(),
        })
    }

    /// Measures one variant. A missing feature or a failure is a row too. The picture is there if it was drawn.
    pub fn measure(&mut self, spec: &Spec) -> (Row, Option<Picture>) {
        let mut row = Row {
            scene: self.scene.name.clone(),
            technique: spec.entry.name.into(),
            variant: spec.variant(),
            path: spec.value("path").into(),
            status: Status::Ok,
            reason: String::new(),
            host_ns: None,
            frame_ns: None,
            standard_error: None,
            flicker_rms: None,
            build_ns: None,
            lookup_ns_per_million: None,
            draw_ns: None,
            passes: Vec::new(),
            bytes_resident: None,
            bytes_transient: None,
            counters: BTreeMap::new(),
            error: None,
            limit_mean_abs: None,
            picture: None,
            difference: None,
        };
        match self.fill(spec, &mut row) {
            Ok(picture) => (row, Some(picture)),
            Err(error) => {
                row.status = if matches!(error, Error::Refused { .. }) { Status::Refused } else { Status::Failed };
                row.reason = error.to_string();
                (row, None)
            }
        }
    }

    fn fill(&mut self, spec: &Spec, row: &mut Row) -> Result<Picture> {
        let lighting = Lighting::of(spec);
        self.context.features().require(lighting.requires())?;
        let mut opened = technique::open(&self.context, &self.world, spec)?;
        let (frames, host_ns) = self.time_builds(&mut opened)?;
        row.host_ns = Timing::of(&host_ns);
        row.build_ns = Timing::of(&frames.iter().filter_map(|f| frame_ns(f)).collect::<Vec<_>>());
        row.passes = pass_timings(&frames);
        let facts = opened.technique.facts()?;
        row.path = facts.path.into();
        row.reason = facts.reason;
        row.bytes_resident = Some(facts.bytes_resident);
        row.bytes_transient = Some(facts.bytes_transient);
        row.counters = facts.counters;
        row.counters.insert("passes_if_unchanged".into(), opened.build(&self.world)?.passes.len() as u64);
        let technique = opened.technique.as_ref();
        row.lookup_ns_per_million = self.time_lookups(technique)?;

        let space = self.space.iter().enumerate().map(|(light, s)| (light, &s.points[..s.truth.len()], &s.truth[..]));
        let space = self.error(technique, space)?;
        // What has no maps has no map error.
        let views: Vec<View> = technique.maps().iter().map(|m| m.volume).collect();
        let mut map = None;
        if !views.is_empty() {
            let place = self.truth_of(views);
            let MapsTruth { truths, limits, .. } = &self.maps[place];
            let limit = LIMIT_NODES.iter().position(|k| Some(*k as u32) == facts.nodes);
            let covered = truths.iter().any(|t| !t.texels.is_empty());
            row.limit_mean_abs = limit.filter(|_| covered).map(|i| limits[i]);
            let sum = |of: fn(&MapTruth) -> u64| truths.iter().map(of).sum();
            row.counters.insert("reference_covered_texels".into(), sum(|t| t.texels.len() as u64));
            row.counters.insert("reference_fragments".into(), sum(|t| t.segments));
            map = self.error(technique, truths.iter().map(|t| (t.light, &t.points[..], &t.visibility[..])))?;
        }

        let renderer = Renderer::new(&self.context, &self.world, &self.camera)?;
        let kernels = renderer.kernels(&technique.answer(), lighting)?;
        row.draw_ns = self.time_draws(|| renderer.draw(&kernels, Shading::Forward))?;
        let picture = renderer.read()?;
        row.error = Some(RowError { map, space, surface: None, image: Some(picture_error(&picture, &self.reference)) });
        Ok(picture)
    }

    /// The place of the truth in maps of these views, which many variants share.
    fn truth_of(&mut self, views: Vec<View>) -> usize {
        if let Some(place) = self.maps.iter().position(|m| m.views == views) {
            return place;
        }
        let truths = map_truths(&self.casters, self.scene, &views);
        let limits = limit_mean_abs(&self.casters, &views, &truths, &LIMIT_NODES);
        self.maps.push(MapsTruth { views, truths, limits });
        self.maps.len() - 1
    }

    /// Over all points of all lights together, if there are any; each item is a light, points and the truth there.
    fn error<'p>(
        &self,
        technique: &dyn Technique,
        parts: impl Iterator<Item = (usize, &'p [[f32; 3]], &'p [f64])>,
    ) -> Result<Option<PointError>> {
        let (mut answers, mut all) = (Vec::new(), Vec::new());
        for (light, points, truth) in parts {
            answers.extend(self.ask(technique, light, points)?);
            all.extend(truth);
        }
        point_error(&answers, &all)
    }

    /// The passes of each build, and the host's time for each.
    fn time_builds(&self, technique: &mut Opened) -> Result<(Vec<Vec<PassTime>>, Vec<f64>)> {
        // By frames and by time: a GPU that idled needs some milliseconds of work to reach its clock.
        let start = std::time::Instant::now();
        let mut warm_up = 0;
        while warm_up < self.effort.warm_up || start.elapsed() < WARM_UP {
            technique.rebuild(&self.world)?;
            warm_up += 1;
        }
        let builds: Result<Vec<_>> = (0..self.effort.frames).map(|_| technique.rebuild(&self.world)).collect();
        Ok(builds?.into_iter().map(|build| (build.passes, build.host_ns)).unzip())
    }

    fn time_lookups(&self, technique: &dyn Technique) -> Result<Option<Timing>> {
        let mut queries = Vec::new();
        let mut points = 0;
        for (light, space) in self.space.iter().enumerate() {
            let share = &space.points[..space.points.len().min(LOOKUPS / self.space.len())];
            points += share.len();
            let query = Query::new(&self.context, light, share)?;
            queries.push((query.kernel(&technique.answer())?, query));
        }
        let mut samples = Vec::new();
        let start = std::time::Instant::now();
        for frame in 0..1 + self.effort.frames {
            // A list on a software device takes seconds a million.
            if frame > 1 && start.elapsed() > LOOKUP_BUDGET {
                break;
            }
            let mut time_ns = Some(0.0);
            for (kernel, query) in &queries {
                let time = query.query(kernel)?;
                time_ns = time_ns.zip(time).map(|(sum, time)| sum + time.end_ns - time.start_ns);
            }
            if let (Some(time_ns), true) = (time_ns, frame > 0) {
                samples.push(time_ns * 1e6 / points.max(1) as f64);
            }
        }
        Ok(Timing::of(&samples))
    }

    /// The time of the last pass of each drawing. The first warms up; where it takes the whole budget it is the only one.
    fn time_draws(&self, draw: impl Fn() -> Result<Vec<PassTime>>) -> Result<Option<Timing>> {
        let mut samples = Vec::new();
        let start = std::time::Instant::now();
        for frame in 0..1 + self.effort.frames {
            if frame > 0 && start.elapsed() > DRAW_BUDGET {
                break;
            }
            samples.extend(draw()?.last().map(|pass| pass.end_ns - pass.start_ns));
        }
        let warm_up = usize::from(samples.len() > 1);
        Ok(Timing::of(&samples[warm_up..]))
    }

    /// Visibility of a light at `points`, asked a million at a time.
    fn ask(&self, technique: &dyn Technique, light: usize, points: &[[f32; 3]]) -> Result<Vec<f32>> {
        let ask = |chunk: &[[f32; 3]]| Query::new(&self.context, light, chunk)?.ask(&technique.answer());
        Ok(points.chunks(LOOKUPS).map(ask).collect::<Result<Vec<_>>>()?.concat())
    }
}

/// From the start of the first pass to the end of the last.
fn frame_ns(passes: &[PassTime]) -> Option<f64> {
    Some(passes.last()?.end_ns - passes.first()?.start_ns)
}

/// One timing a pass name, in the order of the first frame: the time of all passes of that name in a frame, since a
/// build runs a pass once for each map.
fn pass_timings(frames: &[Vec<PassTime>]) -> Vec<PassTiming> {
    let Some(first) = frames.first() else { return Vec::new() };
    let mut names: Vec<&str> = Vec::new();
    for pass in first {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    let timing = |name: &str| {
        let frame_ns = |f: &Vec<PassTime>| f.iter().filter(|p| p.name == name).map(|p| p.end_ns - p.start_ns).sum();
        let timing = Timing::of(&frames.iter().map(frame_ns).collect::<Vec<f64>>())?;
        Some(PassTiming { name: name.into(), median_ns: timing.median, p05_ns: timing.p05, p95_ns: timing.p95 })
    };
    names.into_iter().filter_map(timing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_one_name_are_summed() {
        let pass = |name: &str, start_ns: f64, end_ns: f64| PassTime { name: name.into(), start_ns, end_ns };
        let frame = |by: f64| {
            vec![pass("a", 0.0, by), pass("b", 10.0, 12.0), pass("a", 20.0, 21.0), pass("b", 30.0, 30.0 + by)]
        };
        let timings = pass_timings(&[frame(1.0), frame(3.0), frame(5.0)]);
        let medians: Vec<_> = timings.iter().map(|t| (t.name.as_str(), t.median_ns)).collect();
        assert_eq!(medians, [("a", 4.0), ("b", 5.0)]);
    }
}
