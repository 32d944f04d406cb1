//! One row of a comparison: build, time, ask, draw, compare with the truth, in a world that is still or moves.

pub(super) mod built_techniques;
pub(super) mod camera_sweep;
pub(super) mod frames;
pub(super) mod points;
pub(super) mod prepare;
pub(super) mod sampling;
pub(super) mod truth;

use crate::advice::advised;
use crate::animate::Simulation;
use crate::bench::case::camera_sweep::references;
use crate::bench::case::frames::{Frames, States};
use crate::bench::case::points::of_each_light;
use crate::bench::case::sampling::{SampledErrors, moments};
use crate::bench::case::truth::{Known, LitPicture, Truth, Wanted};
use crate::bench::error::footprint::Footprints;
use crate::bench::error::picture_error::bounce_error;
use crate::bench::picture_error;
use crate::bench::timing::cost::{Unshadowed, add_cost};
use crate::bench::timing::passes::{frame_ns, pass_counts, pass_timings};
use crate::bench::timing::stability::ClockMeter;
use crate::bench::timing::timed_runs::{DrawTimes, LookupTimes, TimedBuilds, TimedRun};
use crate::bench::{Extent, PassCount, Row, RowError, Status, Timing};
use crate::gpu::{Context, PassTime};
use crate::reference::truth::{Bounce, Casters, bounce, bounds, points_outside, points_within};
use crate::scene::{Picture, View};
use crate::shading::{Lighting, PainterKind, Renderer, Shading};
use crate::technique::{self, Lifetime, Name, Spec};
use crate::world::World;
use crate::{Error, Result};
use glam::DVec3;
use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The most look-ups that are timed or asked at once.
pub const LOOKUPS: usize = 1_000_000;

/// Points per light at which a moving world is watched; fewer where there are many lights.
const WATCHED: usize = 2048;

/// The fewest seen points of each frame of a moving world.
const LEAST_SEEN: usize = 256;

/// Processors that are left for measuring while others compute the truth.
const KEPT_PROCESSORS: usize = 2;

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Builds that are timed in a still world; fewer for baked techniques that take long.
    pub frames: usize,
    /// Frames that warm up before those, and are not timed.
    pub warm_up: usize,
    /// How many points in space per light are compared with the truth, and how many points on surfaces. With more than eight lights there
    /// are fewer per light.
    pub space_points: usize,
    /// Look-ups that are timed at once, an equal share per light; 0 times none.
    pub lookups: usize,
    /// How many seen points are compared with the truth, of all frames together.
    pub seen_points: usize,
    /// Size of the picture, pixels.
    pub picture: [u32; 2],
    /// Whether pictures of consecutive frames are compared with the truth's.
    pub turning: bool,
    /// Whether answers are also compared with means over areas. Where the world moves, in its first frame.
    pub footprints: bool,
    /// Whether passes count their work, in one more build and picture. Where the world moves, in its last frame.
    pub counts: bool,
    /// How much of the truth is computed.
    pub truth: Extent,
}

impl Effort {
    /// Whether rows are measured only for a choice between them.
    pub(in crate::bench) fn is_choice(&self) -> bool {
        matches!(self.truth, Extent::Glance | Extent::Choice)
    }
}

/// A scene with everything that its rows share: its states at one time or more.
pub struct SceneCase<'a> {
    pub(in crate::bench) context: &'a Context,
    pub(in crate::bench) frames: Frames<'a>,
    /// Moves the world on the device, where the device simulates it.
    pub(in crate::bench) simulation: Option<Simulation>,
    /// The truth in each frame, of states that are in memory.
    truths: &'a [Truth<'a>],
    /// What is known of the truth in each frame.
    known: &'a [Arc<Known>],
    pub(in crate::bench) world: World,
    pub(in crate::bench) effort: Effort,
    /// Pictures of consecutive frames, once they are asked for.
    references: OnceCell<Arc<Vec<Picture>>>,
    /// The bounce of light that virtual lights represent; computed when first asked for.
    bounce: OnceCell<Bounce>,
    /// Means over areas, once asked for.
    pub(in crate::bench) footprints: OnceCell<Footprints>,
    /// Pictures without shadows, once they are drawn.
    pub(in crate::bench) unshadowed: Vec<(PictureWay, Unshadowed)>,
    /// What makes the pictures of the row that is measured.
    pub(in crate::bench) painter: Option<PainterKind>,
    pub(in crate::bench) clock: Arc<ClockMeter>,
    /// Per light, the points at which look-ups are timed.
    pub(in crate::bench) asked: Vec<Vec<[f32; 3]>>,
    /// Techniques and paths whose first build is like the later ones.
    pub(in crate::bench) alike: BTreeSet<(String, String)>,
}

/// How a row's picture is made.
pub(in crate::bench) type PictureWay = (Shading, Lighting, Option<PainterKind>);

/// Uploads a scene, whose state in each frame is in `frames`, and calls `measure` with it. The truth is computed during the measuring where
/// the device is no CPU and there are CPU cores to spare.
///
/// # Errors
/// [`Error::Gpu`] where memory runs out, and those of `measure`.
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
    let boxes = (0..states.count()).map(|frame| Ok(bounds(states.at(frame)?.as_ref()))).collect::<Result<Vec<_>>>()?;
    let all = boxes.iter().copied().flatten().reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]);
    // Points per light.
    let within = |points: &dyn Fn(usize, [DVec3; 2]) -> Vec<[f32; 3]>| -> Vec<_> {
        (0..first.lights.len()).map(|light| all.map_or_else(Vec::new, |all| points(light, all))).collect()
    };
    let watched = of_each_light(WATCHED, first.lights.len());
    let watch = |casters: &Casters| within(&|light, all| points_outside(casters, all, light, watched));
    let watched = Arc::new(if states.count() > 1 { watch(&Casters::new(first)) } else { Vec::new() });
    let seen = effort.seen_points / states.count();
    let known = |(frame, bounds): (usize, _)| {
        Arc::new(Known::new(Wanted {
            extent: effort.truth,
            points: of_each_light(effort.space_points, first.lights.len()),
            seen: (seen.max(LEAST_SEEN.min(effort.seen_points)), frame as u64),
            picture: effort.picture,
            bounds,
            watched: watched.clone(),
        }))
    };
    let known: Vec<_> = boxes.into_iter().enumerate().map(known).collect();
    let truths: Vec<Truth> = match states {
        States::Held(states) => {
            states.iter().zip(&known).map(|(scene, known)| Truth::of(scene, known.clone())).collect()
        }
        States::Read { .. } => Vec::new(),
    };
    let world = World::new(context, first)?;
    let count = effort.lookups / first.lights.len().max(1);
    let asked = within(&|light, all| points_within(all, &first.lights[light], count));
    let fountain = frames.fountain.filter(|_| !frames.times_s.is_empty());
    let simulation = fountain.map(|fountain| Simulation::new(context, &world, fountain)).transpose()?;
    let mut case = SceneCase {
        context,
        frames,
        simulation,
        truths: &truths,
        known: &known,
        world,
        effort,
        references: OnceCell::new(),
        bounce: OnceCell::new(),
        footprints: OnceCell::new(),
        unshadowed: Vec::new(),
        painter: None,
        clock: Arc::new(ClockMeter::of(context.features())),
        asked,
        alike: BTreeSet::new(),
    };
    let spare = std::thread::available_parallelism().map_or(1, |n| n.get()).saturating_sub(KEPT_PROCESSORS);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(spare.max(1)).build().ok();
    let beside = effort.truth != Extent::None && spare > 0 && !context.features().is_software();
    let stop = AtomicBool::new(false);
    std::thread::scope(|threads| {
        if let (Some(pool), true) = (&pool, beside) {
            let (stop, truths) = (&stop, &truths);
            threads.spawn(move || pool.install(|| prepare(truths, stop)));
        }
        let measured = measure(&mut case);
        stop.store(true, Ordering::Relaxed);
        measured
    })
}

/// Computes the parts of all frames' truth that depend on no technique, until `stop` is set.
fn prepare(truths: &[Truth], stop: &AtomicBool) {
    let moments = moments(truths.len());
    let stopped = || stop.load(Ordering::Relaxed);
    for (frame, truth) in truths.iter().enumerate() {
        if !stopped() {
            truth.seen();
        }
        if truths.len() > 1 && !stopped() {
            truth.watched();
        }
        let has_reasons = truth.known().has_reasons() && moments.contains(&frame);
        if has_reasons && !stopped() {
            truth.space();
        }
        if has_reasons && !stopped() {
            truth.surface();
        }
        if moments.last() == Some(&frame) && truth.known().has_picture() && !stopped() {
            truth.picture();
        }
    }
}

impl SceneCase<'_> {
    /// The picture lit by the truth; none where it has not been made.
    pub fn reference(&self) -> Option<&Picture> {
        let known = self.known.last().filter(|known| self.effort.truth != Extent::None && known.has_picture())?;
        let lit = self.truths.last().map_or_else(|| known.picture(), Truth::picture);
        lit.map(|lit| &lit.picture)
    }

    /// The last frame's picture, lit by the truth; none where none is wanted or it would take long.
    pub(in crate::bench) fn lit(&self) -> Result<Option<&LitPicture>> {
        let Some(last) = self.known.last().filter(|known| known.has_picture()) else { return Ok(None) };
        if !last.has_tried_picture() {
            self.with_truth(self.known.len() - 1, |truth| {
                truth.picture();
                Ok(())
            })?;
        }
        Ok(last.picture())
    }

    /// Calls `ask` with the truth in a frame. What is in no memory is read, and given back.
    pub(in crate::bench) fn with_truth<R>(&self, frame: usize, ask: impl FnOnce(&Truth) -> Result<R>) -> Result<R> {
        if let Some(truth) = self.truths.get(frame) {
            return ask(truth);
        }
        let state = self.frames.states.at(frame)?;
        ask(&Truth::of(&state, self.known[frame].clone()))
    }

    /// One bounce of light, if pictures were compared with it by now.
    pub fn traced(&self) -> Option<&Picture> {
        self.bounce.get().map(|bounce| &bounce.picture)
    }

    /// The scene's name.
    pub fn scene_name(&self) -> &str {
        self.frames.states.first().map_or("", |first| first.name.as_str())
    }

    /// Measures one variant. A missing feature or a failure gives a row too. Returns the picture if it was drawn.
    pub fn measure(&mut self, spec: &Spec) -> (Row, Option<CasePictures>) {
        let mut row = Row {
            scene: self.world.name().into(),
            technique: spec.entry.name.into(),
            variant: spec.variant(),
            path: spec.text(Name::PATH).into(),
            unseen: spec.entry.casts.unseen_of(self.world.kinds()),
            ..Row::default()
        };
        match self.fill(spec, &mut row) {
            Ok(picture) => (row, Some(picture)),
            Err(error) => {
                row.status = if matches!(error, Error::Refused(_)) { Status::Refused } else { Status::Failed };
                row.reason = advised(error).to_string();
                (row, None)
            }
        }
    }

    /// Pictures of the present world, made as the row that is measured says.
    pub(in crate::bench) fn renderer(&self, camera: &View) -> Result<Renderer> {
        let mut renderer = Renderer::new(self.context, &self.world, camera)?;
        renderer.paint_by(self.painter);
        Ok(renderer)
    }

    fn fill(&mut self, spec: &Spec, row: &mut Row) -> Result<CasePictures> {
        let settings = spec.settings();
        let (lighting, shading) = (Lighting::of(&settings), Shading::of(&settings));
        self.painter = settings.painter;
        settings.check(self.context.features())?;
        self.show(0)?;
        let mut opened = technique::open(self.context, &self.world, spec)?;
        let first = TimedRun::of(|| {
            let built = opened.build(&self.world)?;
            row.first_ns = built.device_ns;
            Ok(built)
        })?;
        row.first_host_ns = Some(first.host_ns);
        let path = if self.alike.is_empty() { "" } else { opened.technique.facts()?.path };
        let first = self.builds_once(spec.entry.name, path, &first).then_some(first);
        let mut timed = self.time_builds(&mut opened, spec.entry.lifetime, shading, first)?;
        row.host_ns = Timing::of(&timed.host_ns());
        row.build_ns = Timing::of(&self.device_ns(&timed, spec.entry.lifetime));
        row.passes = [&timed.moves, &timed.passes()].into_iter().flat_map(|passes| pass_timings(passes)).collect();
        row.steadiness = Some(timed.steadiness);
        if self.effort.counts {
            row.counts = self.counted(|| Ok(opened.rebuild(&self.world)?.passes))?;
        }
        let facts = opened.technique.facts()?;
        row.path = facts.path.into();
        row.reason = facts.reason;
        row.bytes_resident = Some(facts.bytes_resident);
        row.bytes_transient = Some(facts.bytes_transient);
        row.bytes_on_disk = facts.bytes_on_disk;
        row.variant.extend(facts.found);
        row.counters = facts.counters;
        row.counters.insert("passes_if_unchanged".into(), opened.build(&self.world)?.passes.len() as u64);
        // A painter has no look-up in space: its errors there are absent.
        if self.effort.lookups > 0 && opened.technique.painter().is_none() {
            timed.built.lookups = self.time_lookups(opened.technique.as_ref())?;
            timed.built.lookups_clock = self.context.calibrate();
            let samples: Vec<f64> = timed.built.lookups.iter().filter_map(LookupTimes::ns_per_million).collect();
            row.lookup_ns_per_million = Timing::of(&samples);
        }

        let mut asked = SampledErrors::default();
        if self.effort.truth != Extent::None {
            row.flicker_rms = self.ask_frames(&mut opened, &mut asked)?;
            self.count(&asked, facts.nodes, row);
            row.colors = asked.colors.errors(&self.world)?;
        }
        let camera = self.camera(self.effort.picture)?;
        let renderer = self.renderer(&camera)?;
        let kernels = renderer.kernels_of(opened.technique.as_ref(), shading, lighting)?;
        row.painter = kernels.painter().word().into();
        let DrawTimes { frames, mut counted_ns } = self.time_draws(shading, &renderer, &kernels)?;
        timed.built.draws = frames;
        timed.built.draws_clock = self.context.calibrate();
        let mut drawn: Vec<_> = timed.built.draws.iter().map(|ran| ran.passes.clone()).collect();
        if !timed.draws.is_empty() {
            // For a simulated scene, the times that count are those of its frames. There particles are drawn in the order in which they
            // come from the device. The picture that is compared with the truth blends them from far to near, and is no part of a frame.
            drawn = timed.draws;
            counted_ns = drawn.iter().filter_map(|f| frame_ns(f)).collect();
        }
        row.draw_ns = Timing::of(&counted_ns);
        row.draw_passes = pass_timings(&drawn);
        if self.effort.counts {
            renderer.forget_order();
            row.counts.extend(self.counted(|| renderer.draw(&kernels))?);
        }
        row.counters.extend(renderer.lists_bytes(&kernels).map(|bytes| ("lists_bytes".into(), bytes)));
        row.counters.extend(renderer.tiles_bytes().map(|bytes| ("tiles_bytes".into(), bytes)));
        row.counters.extend(renderer.estimates_bytes(&kernels).map(|bytes| ("estimates_bytes".into(), bytes)));
        // A bake is no part of a frame in which nothing moved.
        let bakes = spec.entry.lifetime == Lifetime::Baked && self.frames.count() == 1;
        let build = if bakes { Some(0.0) } else { row.build_ns.map(|build| build.median) };
        row.frame_ns = build.zip(row.draw_ns).map(|(build, draw)| build + draw.median);
        let unshadowed = self.unshadowed(shading, lighting)?;
        add_cost(row, row.build_ns.filter(|_| !bakes), unshadowed);
        let picture = match shading {
            // With reservoir shading every frame is different. So the picture is drawn anew from the first frame on, with as many frames as
            // it needs to settle; the frames that were timed do not count.
            Shading::Reservoir => renderer.picture_of(opened.technique.as_ref(), shading, lighting)?,
            _ => renderer.read()?,
        };
        let mut beside_truth = None;
        if self.effort.truth != Extent::None {
            let mut image = None;
            if let Some(lit) = self.lit()? {
                let drawn = if lit.camera == camera {
                    picture.clone()
                } else {
                    let renderer = self.renderer(&lit.camera)?;
                    renderer.picture_of(opened.technique.as_ref(), shading, lighting)?
                };
                let mut error = picture_error(&drawn, &lit.picture);
                if let Some(bounce) = self.bounce(&lit.camera) {
                    [error.bounce_rmse, error.bounce_noise] = bounce_error(&drawn, bounce).map(Some);
                }
                image = Some(error);
                beside_truth = Some(drawn);
            }
            let (map, space, surface) = (asked.map.error()?, asked.space.error()?, asked.surface.error()?);
            let seen = asked.seen.error();
            row.error = Some(RowError { seen, map, space, surface, casters: asked.surface.caster_error(), image });
        }
        if self.effort.footprints && opened.technique.painter().is_none() {
            self.show(0)?;
            opened.build(&self.world)?;
            row.footprints = self.ask_footprints(opened.technique.as_ref())?;
        }
        if self.effort.turning && self.effort.truth != Extent::None {
            row.frames = self.turn(&mut opened, shading, lighting)?;
        }
        Ok(CasePictures { picture, beside_truth, builds: timed.built })
    }

    /// Counts of passes, by name, in the submissions of `run`.
    fn counted(&self, run: impl FnOnce() -> Result<Vec<PassTime>>) -> Result<Vec<PassCount>> {
        self.context.count_passes(true);
        let passes = run();
        self.context.count_passes(false);
        Ok(pass_counts(&passes?))
    }

    /// The true pictures of consecutive frames.
    pub(in crate::bench) fn references(&self) -> Result<Arc<Vec<Picture>>> {
        if let Some(made) = self.references.get() {
            return Ok(made.clone());
        }
        let made = Arc::new(references(&self.frames.states)?);
        Ok(self.references.get_or_init(|| made).clone())
    }

    /// One bounce of light in the picture that the truth lights; none unless asked for.
    fn bounce(&self, camera: &View) -> Option<&Bounce> {
        let traced = self.frames.bounce?;
        let made =
            self.bounce.get_or_init(|| bounce(&Casters::new(traced.scene), traced.scene, camera, traced.samples));
        Some(made)
    }

    /// Moves the world to a frame.
    pub(in crate::bench) fn show(&mut self, frame: usize) -> Result<Vec<PassTime>> {
        match &mut self.simulation {
            _ if self.frames.count() == 1 => Ok(Vec::new()),
            Some(simulation) => simulation.move_to(&mut self.world, self.frames.times_s[frame]),
            None => Ok(self.world.replace(self.frames.states.at(frame)?.as_ref())?.pass.into_iter().collect()),
        }
    }

    pub(in crate::bench) fn camera(&self, size: [u32; 2]) -> Result<View> {
        let scene = self.world.scene()?;
        Ok(View::camera(&scene.camera, scene, size))
    }
}

/// A picture, and the same picture at the size of its truth.
pub struct CasePictures {
    /// At the size that was asked for.
    pub picture: Picture,
    /// At the size of [`SceneCase::reference`], with which it is compared.
    pub beside_truth: Option<Picture>,
    /// The builds that were timed before.
    pub builds: TimedBuilds,
}
