//! How long builds, look-ups and pictures of a row take.

use crate::Result;
use crate::bench::case::SceneCase;
use crate::bench::case::frames::Drawing;
use crate::bench::timing::passes::frame_ns;
use crate::bench::timing::repetition::{Repetition, SLOW_WARM_UP, WARM_UP, is_first_like_others, is_long_for_a_choice};
use crate::bench::timing::stability::{Stability, Watch};
use crate::bench::{Row, Timing};
use crate::gpu::{Calibration, PassTime};
use crate::query::{PointBatch, Query};
use crate::shading::{Kernels, Renderer, Shading};
use crate::technique::{Built, Lifetime, Opened, Technique};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// When to stop timing look-ups, after one sample at least.
const LOOKUP_BUDGET: Duration = Duration::from_secs(1);

/// How often the clock is looked at while builds are timed.
const LOOKS: usize = 4;

/// Builds that took longer than this in all are not timed once more.
const AGAIN_BUDGET: Duration = Duration::from_secs(5);

/// When to stop timing pictures, after one at least.
const DRAW_BUDGET: Duration = Duration::from_secs(1);

/// When to stop timing look-ups and pictures on a software device, whose times are for ratios, after [`FEW`] at least.
const SOFTWARE_BUDGET: Duration = Duration::from_millis(250);
const FEW: usize = 3;

/// Whether so many samples, which took so long, are enough. `budget`: for one that takes long.
fn are_enough(samples: usize, took: Duration, budget: Duration, software: bool) -> bool {
    samples > 0 && (took > budget || software && samples >= FEW && took > SOFTWARE_BUDGET)
}

/// Consecutive builds of a row.
#[derive(Default)]
pub(in crate::bench) struct BuildSamples {
    /// How far their times may be trusted.
    pub(in crate::bench) steadiness: Stability,
    /// Each build, and both clocks after the last one.
    pub(in crate::bench) built: TimedBuilds,
    /// Per build, the passes before it that moved the world, where the world moves.
    pub(in crate::bench) moves: Vec<Vec<PassTime>>,
    /// Per build, the passes behind it that drew the world, where the world is simulated.
    pub(in crate::bench) draws: Vec<Vec<PassTime>>,
}

/// The timed builds and pictures of a row.
#[derive(Clone, Debug, Default)]
pub struct TimedBuilds {
    /// In the order in which they ran.
    pub builds: Vec<BuildTimes>,
    /// Relates the device's clock to the host's, read after the last build; none where it cannot be read.
    pub clock: Option<Calibration>,
    /// The look-ups that were timed, behind the builds, in their order.
    pub lookups: Vec<LookupTimes>,
    /// The clocks again, read after the last look-up.
    pub lookups_clock: Option<Calibration>,
    /// The pictures that were timed after the look-ups, in their order.
    pub draws: Vec<TimedRun>,
    /// The clocks again, read after the last picture.
    pub draws_clock: Option<Calibration>,
}

/// One timed build.
#[derive(Clone, Debug)]
pub struct BuildTimes {
    /// With each pass timed.
    pub each: TimedRun,
    /// The same build once more, with one timestamp pair around all passes, so that timestamps between passes cost
    /// nothing. None where the world moves, for a bake, and on a software device.
    pub whole: Option<TimedRun>,
}

/// Timed look-ups at many points at once.
#[derive(Clone, Debug)]
pub struct LookupTimes {
    /// The pass that asked.
    pub ran: TimedRun,
    /// How many points it asked about.
    pub points: usize,
}

/// A build, look-ups or a picture that ran.
#[derive(Clone, Debug)]
pub struct TimedRun {
    /// When the host began to record it.
    pub began: Instant,
    /// The host's time for it: recording, submitting, waiting, settling.
    pub host_ns: f64,
    /// Its passes, or all of them as one.
    pub passes: Vec<PassTime>,
}

impl TimedRun {
    pub(in crate::bench) fn of(build: impl FnOnce() -> Result<Built>) -> Result<Self> {
        let began = Instant::now();
        build().map(|Built { host_ns, passes, .. }| Self { began, host_ns, passes })
    }

    /// Runs passes that do not belong to a build.
    fn passes(run: impl FnOnce() -> Result<Vec<PassTime>>) -> Result<Self> {
        let began = Instant::now();
        run().map(|passes| Self { began, host_ns: began.elapsed().as_nanos() as f64, passes })
    }
}

impl LookupTimes {
    /// Nanoseconds per million points; none where the device has no timestamps.
    pub fn ns_per_million(&self) -> Option<f64> {
        frame_ns(&self.ran.passes).map(|ns| ns * 1e6 / self.points.max(1) as f64)
    }
}

impl BuildTimes {
    /// The run that the row's times are taken from.
    pub fn counted(&self) -> &TimedRun {
        self.whole.as_ref().unwrap_or(&self.each)
    }
}

impl BuildSamples {
    /// The host's time for each.
    pub(in crate::bench) fn host_ns(&self) -> Vec<f64> {
        self.built.builds.iter().map(|build| build.counted().host_ns).collect()
    }

    /// The passes of each, each timed.
    pub(in crate::bench) fn passes(&self) -> Vec<Vec<PassTime>> {
        self.built.builds.iter().map(|build| build.each.passes.clone()).collect()
    }
}

impl SceneCase<'_> {
    /// Times builds. Where the times are not steady, times them once more and keeps the steadier of the two. `first`, the first build of all,
    /// stands for others where it [`SceneCase::builds_once`].
    pub(in crate::bench) fn time_builds(
        &mut self,
        technique: &mut Opened,
        lifetime: Lifetime,
        shading: Shading,
        first: Option<TimedRun>,
    ) -> Result<BuildSamples> {
        if let Some(first) = first {
            let mut timed = BuildSamples::default();
            timed.built.clock = self.context.calibrate();
            timed.built.builds.push(BuildTimes { each: first, whole: None });
            return Ok(timed);
        }
        let first = self.time_builds_once(technique, lifetime, shading)?;
        // Slow builds have few samples, and more would take as long again. A software device's times are for ratios.
        let long = first.host_ns().iter().sum::<f64>() > AGAIN_BUDGET.as_nanos() as f64;
        if first.steadiness.warnings().is_empty() || long || self.context.features().is_software() {
            return Ok(first);
        }
        let second = self.time_builds_once(technique, lifetime, shading)?;
        let mut best = if second.steadiness.is_steadier_than(&first.steadiness) { second } else { first };
        best.steadiness.measured_again = true;
        Ok(best)
    }

    /// Whether a row's first build is enough: the row is only compared for a choice, on a software device, the build took long, and an
    /// earlier row of its path had a first build like the later ones ([`SceneCase::learn`]).
    pub(in crate::bench) fn builds_once(&self, technique: &str, path: &str, first: &TimedRun) -> bool {
        let stands_still = self.frames.count() == 1 && self.simulation.is_none();
        let is_known = self.alike.contains(&(technique.to_owned(), path.to_owned()));
        let is_long = frame_ns(&first.passes).is_some_and(is_long_for_a_choice);
        stands_still && self.context.features().is_software() && self.effort.is_choice() && is_known && is_long
    }

    /// Learns from rows of the same scene which paths have first builds that take long, and no longer than later ones.
    pub fn learn(&mut self, rows: &[Row]) {
        self.alike = alike(rows);
    }

    /// The device's time of each build. A build without passes took no time: nothing that the technique depends on had
    /// moved, or the technique builds nothing. For a baked technique in a still world, such a build gives no time: the
    /// technique was baked before.
    pub(in crate::bench) fn device_ns(&self, timed: &BuildSamples, lifetime: Lifetime) -> Vec<f64> {
        let is_built = self.frames.count() > 1 || lifetime == Lifetime::Frame;
        let has_times = is_built && self.context.features().timestamp_valid_bits > 0;
        let of = |passes: &Vec<PassTime>| frame_ns(passes).or((has_times && passes.is_empty()).then_some(0.0));
        timed.built.builds.iter().map(|build| &build.counted().passes).filter_map(of).collect()
    }

    fn time_builds_once(
        &mut self,
        technique: &mut Opened,
        lifetime: Lifetime,
        shading: Shading,
    ) -> Result<BuildSamples> {
        let count = if self.frames.count() > 1 { self.frames.count() } else { self.effort.frames };
        let camera = self.camera(self.effort.picture)?;
        let drawing = |simulation| Drawing::new(self.context, &self.world, simulation, &camera, technique, shading);
        let drawing = self.simulation.as_ref().map(drawing).transpose()?;
        // On these, builds are not timed as a whole. A software device waits between passes either way. A bake takes
        // long. Where the world moves, a second build of the same frame would find views and orders already made.
        let moves = self.frames.count() > 1 || self.simulation.is_some();
        let software = self.context.features().is_software();
        let twice = !software && lifetime == Lifetime::Frame && !moves;
        let meter = self.clock.clone();
        let mut watch = Watch::begin(&meter);
        let mut looked = 0;
        let repeats = Repetition::of(lifetime, software, self.effort.warm_up, count);
        let repeats = if self.effort.is_choice() { repeats.of_choice(software) } else { repeats };
        // A device without work to build, as where only the camera moves, is idle: its clock then says nothing.
        let works = Cell::new(false);
        let slow = Cell::new(false);
        let is_slow = || {
            slow.set(works.get() && meter.is_slow());
            slow.get()
        };
        let builds = repeats.run(is_slow, |frame, is_timed| {
            let moved = self.show(frame % self.frames.count())?;
            // Where frames differ, only the passes that depend on what has moved; where all frames are alike, all
            // passes.
            let more = self.frames.count() > 1;
            let each =
                TimedRun::of(|| if more { technique.build(&self.world) } else { technique.rebuild(&self.world) })?;
            let mut whole = None;
            if twice {
                self.context.time_passes(false);
                let again = TimedRun::of(|| technique.rebuild(&self.world));
                self.context.time_passes(true);
                whole = Some(again?);
            }
            works.set(!each.passes.is_empty());
            // Asking takes longer than many builds do: a few times is enough. The clock of a warm-up is not counted.
            if is_timed && works.get() && frame * LOOKS >= looked * count {
                looked += 1;
                watch.look();
            }
            Ok((moved, BuildTimes { each, whole }, drawing.as_ref().map(Drawing::draw).transpose()?))
        })?;
        if slow.get() {
            meter.give_up();
        }
        let mut timed = BuildSamples::default();
        timed.built.clock = self.context.calibrate();
        for (moved, build, drawn) in builds {
            timed.moves.extend((!moved.is_empty()).then_some(moved));
            timed.built.builds.push(build);
            timed.draws.extend(drawn);
        }
        let (device, host) = (self.device_ns(&timed, lifetime), timed.host_ns());
        timed.steadiness = watch.end(Timing::of(if device.is_empty() { &host } else { &device }));
        Ok(timed)
    }

    /// Times look-ups at the same points, one pass after the other.
    pub(in crate::bench) fn time_lookups(&self, technique: &dyn Technique) -> Result<Vec<LookupTimes>> {
        let asked = self.asked.iter().enumerate().map(|(light, points)| PointBatch { light, points, normals: &[] });
        let asked: Vec<_> = asked.collect();
        let query = Query::of_lights(self.context, &asked)?;
        let kernel = query.kernel(&technique.answer())?;
        let ask = || query.query(&kernel).map(|time| time.into_iter().collect());
        // Where nothing was built, the device has idled until now.
        let start = Instant::now();
        query.query(&kernel)?;
        while start.elapsed() < SLOW_WARM_UP && self.clock.is_slow() {
            query.query(&kernel)?;
        }
        let software = self.context.features().is_software();
        let mut samples = Vec::new();
        let start = Instant::now();
        for frame in 0..self.effort.frames {
            // A list on a software device takes seconds per million look-ups.
            if are_enough(frame, start.elapsed(), LOOKUP_BUDGET, software) {
                break;
            }
            samples.push(LookupTimes { ran: TimedRun::passes(ask)?, points: query.points() });
        }
        Ok(samples)
    }

    /// The time of each drawing of a picture, with its casters sorted in it, as in a world that moves. The first drawings warm up; on a GPU
    /// they go on until the GPU reaches its clock rate, and each is drawn once more with one timestamp pair around all passes. Where the
    /// first timed drawing takes the whole budget, no more follow, except those that a picture needs until it no longer changes.
    pub(in crate::bench) fn time_draws(
        &self,
        shading: Shading,
        renderer: &Renderer,
        kernels: &Kernels,
    ) -> Result<DrawTimes> {
        let software = self.context.features().is_software();
        let draw = || {
            renderer.forget_order();
            renderer.draw(kernels)
        };
        let sample = || -> Result<(TimedRun, Option<f64>)> {
            let each = TimedRun::passes(draw)?;
            if software {
                let ns = frame_ns(&each.passes);
                return Ok((each, ns));
            }
            self.context.time_passes(false);
            let whole = draw();
            self.context.time_passes(true);
            Ok((each, frame_ns(&whole?)))
        };
        let mut start = Instant::now();
        let mut samples = vec![sample()?];
        // A GPU has idled while the truth was made on the host.
        let idled = start;
        while !software && (idled.elapsed() < WARM_UP || idled.elapsed() < SLOW_WARM_UP && self.clock.is_slow()) {
            samples = vec![sample()?];
            start = Instant::now();
        }
        for frame in 1..1 + self.effort.frames {
            if frame >= shading.frames_to_settle() && are_enough(frame, start.elapsed(), DRAW_BUDGET, software) {
                break;
            }
            samples.push(sample()?);
        }
        let warm_up = usize::from(samples.len() > 1);
        let (frames, counted): (_, Vec<_>) = samples.split_off(warm_up).into_iter().unzip();
        Ok(DrawTimes { frames, counted_ns: counted.into_iter().flatten().collect() })
    }
}

/// Timed pictures.
pub(in crate::bench) struct DrawTimes {
    /// Each, with every pass timed.
    pub frames: Vec<TimedRun>,
    /// The times that count, where the device has timestamps.
    pub counted_ns: Vec<f64>,
}

/// Techniques and paths with a row whose first build took long, where it took no longer than later ones in any such row.
fn alike(rows: &[Row]) -> BTreeSet<(String, String)> {
    let timed = |row: &Row| {
        let (first, later) = row.first_ns.zip(row.build_ns.map(|build| build.median))?;
        let key = (row.technique.clone(), row.path.clone());
        is_long_for_a_choice(first).then(|| (key, is_first_like_others(first, later)))
    };
    let (like, unlike): (Vec<_>, Vec<_>) = rows.iter().filter_map(timed).partition(|(_, is_like)| *is_like);
    let keys = |rows: Vec<((String, String), bool)>| rows.into_iter().map(|(key, _)| key).collect::<BTreeSet<_>>();
    &keys(like) - &keys(unlike)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path is known by rows whose first build took long, and unlearned by one that took longer than the next.
    #[test]
    fn first_builds_are_learned_by_path() {
        let row = |technique: &str, path: &str, first_s: f64, later_s: f64| Row {
            technique: technique.into(),
            path: path.into(),
            first_ns: Some(1e9 * first_s),
            build_ns: Timing::of(&[1e9 * later_s]),
            ..Row::default()
        };
        let rows = [
            row("shadow-map", "raster", 5.2, 5.0),
            row("shadow-map", "compute", 9.0, 8.0),
            row("shadow-map", "compute", 3.8, 0.1),
            row("avsm", "binned", 0.2, 0.1),
            Row { build_ns: None, ..row("avsm", "list", 7.0, 7.0) },
        ];
        let known: Vec<_> = alike(&rows).into_iter().collect();
        assert_eq!(known, [("shadow-map".to_owned(), "raster".to_owned())]);
    }
}
