//! One row of a comparison: build, time, query, draw and compare with the truth, in a static or moving world.

pub(super) mod built_techniques;
pub(super) mod camera_sweep;
pub(super) mod device_scene;
pub(super) mod effort;
pub(super) mod error_sampler;
pub(super) mod frame_truths;
pub(super) mod frames;
pub(super) mod picture_settings;
pub(super) mod points;
pub(super) mod prepare;
pub(super) mod sampled_errors;
pub(super) mod truth;

use crate::advice::advised;
use crate::bench::case::device_scene::DeviceScene;
use crate::bench::case::effort::Effort;
use crate::bench::case::error_sampler::ErrorSampler;
use crate::bench::case::frame_truths::{FrameBounds, FrameTruths, compute_ahead, held_truths, known};
use crate::bench::case::frames::Frames;
use crate::bench::case::picture_settings::PictureSettings;
use crate::bench::case::sampled_errors::SampledErrors;
use crate::bench::timing::cost::{Unshadowed, add_cost};
use crate::bench::timing::passes::{frame_ns, pass_counts, pass_timings};
use crate::bench::timing::timed_runs::{BuildSamples, DrawTimes, LookupTimes, TimedBuilds, TimedRun};
use crate::bench::timing::timer::{Timer, device_ns};
use crate::bench::{Extent, PassCount, Row, Status, Timing};
use crate::gpu::{Context, PassTime};
use crate::reference::truth::points_within;
use crate::scene::{Kinds, Picture, View};
use crate::shading::{Kernels, Renderer, Shading, parse};
use crate::technique::{self, Lifetime, Name, Opened, Spec};
use crate::world::World;
use crate::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of processors reserved for measuring while others compute the truth.
const KEPT_PROCESSORS: usize = 2;

/// A scene in one or more states, with everything that its rows share.
pub struct SceneCase<'a> {
    effort: Effort,
    scene: DeviceScene<'a>,
    timer: Timer,
    errors: ErrorSampler<'a>,
    /// Figures of pictures without shadows, once drawn.
    unshadowed: Vec<(PictureSettings, Unshadowed)>,
}

/// Uploads a scene, whose state in each frame is in `frames`, and calls `measure` with it. The truth is computed during the measurement if
/// the device is not a CPU and there are CPU cores to spare.
///
/// # Errors
/// [`Error::Gpu`] if memory runs out, and any error from `measure`.
pub fn with_case<'a, R>(
    context: &Context,
    frames: impl Into<Frames<'a>>,
    effort: Effort,
    measure: impl FnOnce(&mut SceneCase) -> Result<R>,
) -> Result<R> {
    let frames: Frames = frames.into();
    let states = frames.states;
    let Some(first) = states.first() else {
        return Err(Error::input("the scene", "it has no state", "give one at least"));
    };
    let lights = first.lights.len();
    let bounds = FrameBounds::of(states)?;
    let known = known(states, first, &effort, &bounds);
    let truths = held_truths(states, &known);
    let world = World::new(context, first)?;
    let count = effort.lookups / lights.max(1);
    let lookups = bounds.points(lights, |light, all| points_within(all, &first.lights[light], count));
    let scene = DeviceScene::new(context, frames, world)?;
    let timer = Timer::new(effort, &scene, lookups);
    let all = FrameTruths { states, truths: &truths, known: &known };
    let errors = ErrorSampler::new(effort.truth, all, frames.bounce);
    let mut case = SceneCase { effort, scene, timer, errors, unshadowed: Vec::new() };
    let spare = std::thread::available_parallelism().map_or(1, |n| n.get()).saturating_sub(KEPT_PROCESSORS);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(spare.max(1)).build().ok();
    let beside = effort.truth != Extent::None && spare > 0 && !context.features().is_software();
    let stop = AtomicBool::new(false);
    std::thread::scope(|threads| {
        if let (Some(pool), true) = (&pool, beside) {
            let (stop, truths) = (&stop, &truths);
            threads.spawn(move || pool.install(|| compute_ahead(truths, stop)));
        }
        let measured = measure(&mut case);
        stop.store(true, Ordering::Relaxed);
        measured
    })
}

impl SceneCase<'_> {
    /// Returns the picture lit by the truth; `None` if it has not been rendered.
    pub fn reference(&self) -> Option<&Picture> {
        self.errors.reference()
    }

    /// Returns one bounce of light, if a picture has been compared with it.
    pub fn traced(&self) -> Option<&Picture> {
        self.errors.bounce_picture()
    }

    /// Learns from rows of the same scene which slow paths have a first build that is no slower than later ones, so that one build
    /// suffices.
    pub fn learn(&mut self, rows: &[Row]) {
        self.timer.learn(rows);
    }

    /// Measures one variant. A missing feature or a failure gives a row too. Returns the picture if one was drawn.
    pub fn measure(&mut self, spec: &Spec) -> (Row, Option<CasePictures>) {
        let world = &self.scene.world;
        let mut row = Row {
            scene: world.name().into(),
            technique: spec.entry.name.into(),
            variant: spec.variant(),
            path: spec.text(Name::PATH).into(),
            unseen: unseen(spec, world.kinds()),
            ..Row::default()
        };
        match self.fill(spec, &mut row) {
            Ok(pictures) => (row, Some(pictures)),
            Err(error) => {
                row.status = if matches!(error, Error::Refused(_)) { Status::Refused } else { Status::Failed };
                row.reason = advised(error).to_string();
                (row, None)
            }
        }
    }

    fn fill(&mut self, spec: &Spec, row: &mut Row) -> Result<CasePictures> {
        let settings = spec.settings();
        let look = PictureSettings::of(&settings);
        settings.check(self.scene.features())?;
        self.scene.show(0)?;
        let mut opened = technique::open(self.scene.context, &self.scene.world, spec)?;
        let mut timed = self.fill_builds(spec, look.shading, &mut opened, row)?;
        let nodes = self.fill_facts(&mut opened, row)?;
        // A painter has no look-up in space, so its errors there are absent.
        let has_look_up = opened.technique.answer().painter.is_none();
        if self.effort.lookups > 0 && has_look_up {
            self.fill_lookups(&opened, &mut timed.built, row)?;
        }
        let mut sampled = SampledErrors::default();
        if self.errors.has_truth() {
            sampled = self.errors.sample(&mut self.scene, &mut opened)?;
            row.flicker_rms = sampled.flicker_rms;
            sampled.count_map(nodes, row);
            row.colors = sampled.colors.errors(&self.scene.world)?;
        }
        let camera = self.scene.camera(self.effort.picture)?;
        let renderer = self.scene.renderer(&camera, look)?;
        let kernels = renderer.kernels_of(opened.technique.as_ref(), look.shading, look.lighting)?;
        self.fill_draws(look.shading, &renderer, &kernels, &mut timed, row)?;
        self.fill_cost(spec.entry.lifetime, look, row)?;
        let picture = match look.shading {
            // With reservoir shading every frame is different, so the picture is drawn again from the first frame, with as many frames as
            // it needs to settle; the timed frames do not count.
            Shading::Reservoir => renderer.picture_of(opened.technique.as_ref(), look.shading, look.lighting)?,
            _ => renderer.read()?,
        };
        let mut beside_truth = None;
        if self.errors.has_truth() {
            beside_truth = self.fill_errors(&opened, look, (&camera, &picture), &sampled, row)?;
        }
        if self.effort.footprints && has_look_up {
            self.scene.show(0)?;
            opened.build(&self.scene.world)?;
            row.footprints = self.errors.footprint_errors(&self.scene, opened.technique.as_ref())?;
        }
        if self.effort.turning && self.errors.has_truth() {
            row.frames = self.errors.frames_error(&mut self.scene, &mut opened, look)?;
        }
        Ok(CasePictures { picture, beside_truth, builds: timed.built })
    }

    /// Runs the first build and the timed ones.
    fn fill_builds(
        &mut self,
        spec: &Spec,
        shading: Shading,
        opened: &mut Opened,
        row: &mut Row,
    ) -> Result<BuildSamples> {
        let (scene, lifetime) = (&mut self.scene, spec.entry.lifetime);
        let first = TimedRun::of(|| {
            let built = opened.build(&scene.world)?;
            row.first_ns = built.device_ns;
            Ok(built)
        })?;
        row.first_host_ns = Some(first.host_ns);
        let first = self.timer.builds_once(scene, spec.entry.name, opened, &first)?.then_some(first);
        let timed = self.timer.time_builds(scene, opened, lifetime, shading, first)?;
        row.host_ns = Timing::of(&timed.host_ns());
        row.build_ns = Timing::of(&device_ns(scene, &timed, lifetime));
        row.passes = [&timed.moves, &timed.passes()].into_iter().flat_map(|passes| pass_timings(passes)).collect();
        row.steadiness = Some(timed.steadiness);
        if self.effort.counts {
            row.counts = counted(scene.context, || Ok(opened.rebuild(&scene.world)?.passes))?;
        }
        Ok(timed)
    }

    /// Fills in what the technique reports about itself. Returns the number of nodes of its curves, if it has curves.
    fn fill_facts(&self, opened: &mut Opened, row: &mut Row) -> Result<Option<u32>> {
        let facts = opened.technique.inspect().facts()?;
        row.path = facts.path.into();
        row.reason = facts.reason;
        row.bytes_resident = Some(facts.bytes_resident);
        row.bytes_transient = Some(facts.bytes_transient);
        row.bytes_on_disk = facts.bytes_on_disk;
        row.variant.extend(facts.found);
        row.counters = facts.counters;
        let passes = opened.build(&self.scene.world)?.passes.len();
        row.counters.insert("passes_if_unchanged".into(), passes as u64);
        Ok(facts.nodes)
    }

    fn fill_lookups(&self, opened: &Opened, built: &mut TimedBuilds, row: &mut Row) -> Result<()> {
        built.lookups = self.timer.time_lookups(&self.scene, opened.technique.as_ref())?;
        built.lookups_clock = self.scene.context.calibrate();
        let samples: Vec<f64> = built.lookups.iter().filter_map(LookupTimes::ns_per_million).collect();
        row.lookup_ns_per_million = Timing::of(&samples);
        Ok(())
    }

    /// Fills in the times, counts and buffers of the last frame's picture.
    fn fill_draws(
        &self,
        shading: Shading,
        renderer: &Renderer,
        kernels: &Kernels,
        timed: &mut BuildSamples,
        row: &mut Row,
    ) -> Result<()> {
        row.painter = kernels.painter().word().into();
        let DrawTimes { frames, mut counted_ns } = self.timer.time_draws(&self.scene, shading, renderer, kernels)?;
        timed.built.draws = frames;
        timed.built.draws_clock = self.scene.context.calibrate();
        let mut drawn: Vec<_> = timed.built.draws.iter().map(|ran| ran.passes.clone()).collect();
        if !timed.draws.is_empty() {
            // For a simulated scene, the timed frames count, which draw particles in the order of the device. The picture compared with the
            // truth blends particles from far to near and is not part of a frame.
            drawn = std::mem::take(&mut timed.draws);
            counted_ns = drawn.iter().filter_map(|f| frame_ns(f)).collect();
        }
        row.draw_ns = Timing::of(&counted_ns);
        row.draw_passes = pass_timings(&drawn);
        if self.effort.counts {
            renderer.forget_order();
            row.counts.extend(counted(self.scene.context, || renderer.draw(kernels))?);
        }
        row.counters.extend(renderer.lists_bytes(kernels).map(|bytes| ("lists_bytes".into(), bytes)));
        row.counters.extend(renderer.tiles_bytes().map(|bytes| ("tiles_bytes".into(), bytes)));
        row.counters.extend(renderer.estimates_bytes(kernels).map(|bytes| ("estimates_bytes".into(), bytes)));
        Ok(())
    }

    /// Fills in the time of a frame, and what shadows add to it. A bake is not part of a frame in which nothing moves.
    fn fill_cost(&mut self, lifetime: Lifetime, look: PictureSettings, row: &mut Row) -> Result<()> {
        let bakes = lifetime == Lifetime::Baked && !self.scene.has_frames();
        let build = if bakes { Some(0.0) } else { row.build_ns.map(|build| build.median) };
        row.frame_ns = build.zip(row.draw_ns).map(|(build, draw)| build + draw.median);
        let unshadowed = self.unshadowed(look)?;
        add_cost(row, row.build_ns.filter(|_| !bakes), unshadowed);
        Ok(())
    }

    /// Fills in the errors at points and of the picture. Returns the picture at the size of its truth.
    fn fill_errors(
        &self,
        opened: &Opened,
        look: PictureSettings,
        drawn: (&View, &Picture),
        sampled: &SampledErrors,
        row: &mut Row,
    ) -> Result<Option<Picture>> {
        let (image, beside) = self.errors.picture_error(&self.scene, opened, look, drawn)?.unzip();
        row.error = Some(sampled.row_error(image)?);
        Ok(beside)
    }

    /// Returns the figures of the picture without shadows, drawn with these settings when first needed.
    fn unshadowed(&mut self, look: PictureSettings) -> Result<Unshadowed> {
        if let Some((_, known)) = self.unshadowed.iter().find(|(drawn, _)| *drawn == look) {
            return Ok(*known);
        }
        let mut none = technique::open(self.scene.context, &self.scene.world, &parse("none")?.remove(0))?;
        none.build(&self.scene.world)?;
        let draw_ns = self.timer.time_unshadowed(&self.scene, &none, look)?;
        let [seen, flip_mean] = self.errors.unshadowed(&self.scene, &none, look)?;
        let made = Unshadowed { draw_ns, seen, flip_mean };
        self.unshadowed.push((look, made));
        Ok(made)
    }
}

/// Returns the counts of the passes that `run` submits, by name.
fn counted(context: &Context, run: impl FnOnce() -> Result<Vec<PassTime>>) -> Result<Vec<PassCount>> {
    context.count_passes(true);
    let passes = run();
    context.count_passes(false);
    Ok(pass_counts(&passes?))
}

/// A picture, and the same picture at the size of its truth.
pub struct CasePictures {
    /// The picture at the requested size.
    pub picture: Picture,
    /// The picture at the size of [`SceneCase::reference`], with which it is compared.
    pub beside_truth: Option<Picture>,
    /// The builds that were timed before it.
    pub builds: TimedBuilds,
}

/// Returns the kinds of casters in the scene that do not cast in the row.
fn unseen(spec: &Spec, has: Kinds) -> Vec<String> {
    spec.entry.casts.unseen_of(has)
}
