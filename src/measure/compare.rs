//! One row of a comparison: build, time, ask, draw, compare with the truth.

use super::consume::{Query, Renderer, Shading};
use super::{PassTiming, Row, RowError, Status, Timing, picture_error, point_error};
use crate::gpu::{Context, PassTime};
use crate::reference::{Casters, MapTruth, limit_mean_abs, map_truth, picture, space_points};
use crate::scene::{Picture, Scene, View};
use crate::technique::{LightData, SceneData, Spec, Technique, map_size};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Look-ups that are timed at once.
pub const LOOKUPS: usize = 1_000_000;

/// Shortest warm-up.
const WARM_UP: std::time::Duration = std::time::Duration::from_millis(200);

/// When to stop timing look-ups, after one sample at least.
const LOOKUP_BUDGET: std::time::Duration = std::time::Duration::from_secs(3);

/// Node counts that the limit is computed for.
const LIMIT_NODES: [usize; 3] = [4, 8, 16];

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Frames that are timed.
    pub frames: usize,
    /// Frames before them that are not.
    pub warm_up: usize,
    /// Space points that are compared with the truth.
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
    data: SceneData,
    casters: Casters<'a>,
    camera: View,
    effort: Effort,
    space: Vec<[f32; 3]>,
    space_truth: Vec<f64>,
    /// Map size → truth and limits there.
    maps: BTreeMap<u32, (MapTruth, Vec<f64>)>,
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
        let space = space_points(&casters, scene, LOOKUPS);
        let space_truth = space
            .par_iter()
            .take(effort.space_points)
            .map(|p| casters.visibility(glam::DVec3::from(p.map(f64::from))))
            .collect();
        Ok(Self {
            reference: picture(&casters, scene, &camera),
            context: context.clone(),
            data: SceneData::new(context, scene)?,
            scene,
            casters,
            camera,
            effort,
            space,
            space_truth,
            maps: BTreeMap::new(),
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
            build_ns: None,
            lookup_ns_per_million: None,
            passes: Vec::new(),
            bytes_resident: 0,
            bytes_transient: 0,
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
        let mut technique = (spec.entry.open)(&self.context, self.scene, &self.data, spec)?;
        row.path = technique.path().into();
        let frames = self.time_builds(technique.as_mut())?;
        row.build_ns = Timing::of(&frames.iter().filter_map(|f| frame_ns(f)).collect::<Vec<_>>());
        row.passes = pass_timings(&frames);
        row.reason = technique.reason();
        row.bytes_resident = technique.bytes_resident();
        row.bytes_transient = technique.bytes_transient();
        row.counters = technique.counters()?;
        row.lookup_ns_per_million = self.time_lookups(technique.as_ref())?;

        let size = map_size(spec);
        let limit = LIMIT_NODES.iter().position(|k| *k == spec.number("nodes") as usize);
        let space = self.ask(technique.as_ref(), &self.space[..self.space_truth.len()])?;
        let space = point_error(&space, &self.space_truth)?;
        let (truth, limits) = self.map(size);
        row.limit_mean_abs = limit.map(|i| limits[i]);
        row.counters.insert("reference_covered_texels".into(), truth.texels.len() as u64);
        row.counters.insert("reference_fragments".into(), truth.segments);
        let map = self.ask(technique.as_ref(), &self.maps[&size].0.points)?;
        let map = point_error(&map, &self.maps[&size].0.visibility)?;

        let light = LightData::new(self.scene, size);
        let renderer = Renderer::new(&self.context, self.scene, &self.data, &light, &self.camera)?;
        let (picture, _) = renderer.picture(&technique.visibility(), Shading::Forward)?;
        row.error = Some(RowError { map, space, image: picture_error(&picture, &self.reference) });
        Ok(picture)
    }

    fn map(&mut self, size: u32) -> &(MapTruth, Vec<f64>) {
        self.maps.entry(size).or_insert_with(|| {
            let view = View::volume(self.scene, size);
            let truth = map_truth(&self.casters, &view, self.scene);
            let limits = limit_mean_abs(&self.casters, &view, &truth, &LIMIT_NODES);
            (truth, limits)
        })
    }

    fn time_builds(&self, technique: &mut dyn Technique) -> Result<Vec<Vec<PassTime>>> {
        let mut frames = Vec::with_capacity(self.effort.frames);
        // By frames and by time: a GPU that idled needs some milliseconds of work to reach its clock.
        let start = std::time::Instant::now();
        let mut warm_up = 0;
        while warm_up < self.effort.warm_up || start.elapsed() < WARM_UP {
            technique.build()?;
            warm_up += 1;
        }
        for _ in 0..self.effort.frames {
            frames.push(technique.build()?);
        }
        Ok(frames)
    }

    fn time_lookups(&self, technique: &dyn Technique) -> Result<Option<Timing>> {
        let query = Query::new(&self.context, &self.space)?;
        let visibility = technique.visibility();
        let pipeline = query.pipeline(&visibility)?;
        let mut samples = Vec::new();
        let start = std::time::Instant::now();
        for frame in 0..1 + self.effort.frames {
            // A list on a software device takes seconds a million.
            if frame > 1 && start.elapsed() > LOOKUP_BUDGET {
                break;
            }
            let time = query.query(&pipeline, &visibility)?;
            if let (Some(time), true) = (time, frame > 0) {
                samples.push((time.end_ns - time.start_ns) * 1e6 / self.space.len().max(1) as f64);
            }
        }
        Ok(Timing::of(&samples))
    }

    /// Visibility at `points`, asked a million at a time.
    fn ask(&self, technique: &dyn Technique, points: &[[f32; 3]]) -> Result<Vec<f32>> {
        let mut answers = Vec::with_capacity(points.len());
        let visibility = technique.visibility();
        for chunk in points.chunks(LOOKUPS) {
            let query = Query::new(&self.context, chunk)?;
            let pipeline = query.pipeline(&visibility)?;
            query.query(&pipeline, &visibility)?;
            answers.extend(query.answers()?);
        }
        Ok(answers)
    }
}

/// From the start of the first pass to the end of the last.
fn frame_ns(passes: &[PassTime]) -> Option<f64> {
    Some(passes.last()?.end_ns - passes.first()?.start_ns)
}

/// One timing a pass, in the order of the first frame.
fn pass_timings(frames: &[Vec<PassTime>]) -> Vec<PassTiming> {
    let Some(first) = frames.first() else { return Vec::new() };
    first
        .iter()
        .enumerate()
        .filter_map(|(i, pass)| {
            let samples: Vec<_> = frames.iter().filter_map(|f| f.get(i)).map(|p| p.end_ns - p.start_ns).collect();
            let timing = Timing::of(&samples)?;
            Some(PassTiming {
                name: pass.name.clone(),
                median_ns: timing.median,
                p05_ns: timing.p05,
                p95_ns: timing.p95,
            })
        })
        .collect()
}
