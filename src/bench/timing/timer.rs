//! The timer: measures how long a row's builds, look-ups and pictures take.

use crate::Result;
use crate::bench::case::device_scene::DeviceScene;
use crate::bench::case::effort::Effort;
use crate::bench::case::frames::Drawing;
use crate::bench::case::picture_settings::PictureSettings;
use crate::bench::timing::passes::frame_ns;
use crate::bench::timing::repetition::{Repetition, SLOW_WARM_UP, WARM_UP, is_first_like_others, is_long_for_a_choice};
use crate::bench::timing::stability::{ClockMeter, Watch};
use crate::bench::timing::timed_runs::{BuildSamples, BuildTimes, DrawTimes, LookupTimes, TimedRun};
use crate::bench::{Row, Timing};
use crate::gpu::PassTime;
use crate::query::{PointBatch, Query};
use crate::shading::{Kernels, Renderer, Shading};
use crate::technique::{Lifetime, Opened, Technique};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// When to stop timing look-ups, after at least one sample.
const LOOKUP_BUDGET: Duration = Duration::from_secs(1);

/// Number of times that the device's clock rate is read while builds are timed.
const LOOKS: usize = 4;

/// Builds that took longer than this in all are not timed again.
const AGAIN_BUDGET: Duration = Duration::from_secs(5);

/// When to stop timing pictures, after at least one.
const DRAW_BUDGET: Duration = Duration::from_secs(1);

/// When to stop timing look-ups and pictures on a software device, whose times are only good for ratios, after at least [`FEW`].
const SOFTWARE_BUDGET: Duration = Duration::from_millis(250);
const FEW: usize = 3;

/// Whether sampling can stop after `samples` samples that took `took` in all; `budget` limits that time.
fn are_enough(samples: usize, took: Duration, budget: Duration, software: bool) -> bool {
    samples > 0 && (took > budget || software && samples >= FEW && took > SOFTWARE_BUDGET)
}

/// See the module documentation.
pub(in crate::bench) struct Timer {
    effort: Effort,
    clock: ClockMeter,
    /// Points per light at which look-ups are timed.
    points: Vec<Vec<[f32; 3]>>,
    /// Techniques and paths whose first build takes no longer than later ones.
    alike: BTreeSet<(String, String)>,
}

impl Timer {
    pub fn new(effort: Effort, scene: &DeviceScene, points: Vec<Vec<[f32; 3]>>) -> Self {
        Self { effort, clock: ClockMeter::of(scene.features()), points, alike: BTreeSet::new() }
    }

    /// Learns from rows of the same scene which slow paths have a first build that is no slower than later ones, so that one build
    /// suffices.
    pub fn learn(&mut self, rows: &[Row]) {
        self.alike = alike(rows);
    }

    /// Whether a row's first build is enough: the row is only measured for a choice, on a software device, the build took long, and an
    /// earlier row of its path had a first build like the later ones ([`Timer::learn`]). `name` is the technique's name.
    pub fn builds_once(&self, scene: &DeviceScene, name: &str, opened: &Opened, first: &TimedRun) -> Result<bool> {
        if self.alike.is_empty() {
            return Ok(false);
        }
        let is_known = self.alike.contains(&(name.to_owned(), opened.technique.inspect().facts()?.path.to_owned()));
        let is_long = frame_ns(&first.passes).is_some_and(is_long_for_a_choice);
        Ok(scene.is_still() && scene.features().is_software() && self.effort.is_choice() && is_known && is_long)
    }

    /// Times builds. If the times are not steady, times them again and keeps the steadier of the two. `first`, the very first build, serves
    /// as the only sample if the technique [`Timer::builds_once`].
    pub fn time_builds(
        &self,
        scene: &mut DeviceScene,
        technique: &mut Opened,
        lifetime: Lifetime,
        shading: Shading,
        first: Option<TimedRun>,
    ) -> Result<BuildSamples> {
        if let Some(first) = first {
            let mut timed = BuildSamples::default();
            timed.built.clock = scene.context.calibrate();
            timed.built.builds.push(BuildTimes { each: first, whole: None });
            return Ok(timed);
        }
        let first = self.time_builds_once(scene, technique, lifetime, shading)?;
        // Slow builds have few samples, and more would take as long again. A software device's times are only good for ratios.
        let long = first.host_ns().iter().sum::<f64>() > AGAIN_BUDGET.as_nanos() as f64;
        if first.steadiness.warnings().is_empty() || long || scene.features().is_software() {
            return Ok(first);
        }
        let second = self.time_builds_once(scene, technique, lifetime, shading)?;
        let mut best = if second.steadiness.is_steadier_than(&first.steadiness) { second } else { first };
        best.steadiness.measured_again = true;
        Ok(best)
    }

    fn time_builds_once(
        &self,
        scene: &mut DeviceScene,
        technique: &mut Opened,
        lifetime: Lifetime,
        shading: Shading,
    ) -> Result<BuildSamples> {
        let count = if scene.has_frames() { scene.frames.count() } else { self.effort.frames };
        let drawing = scene.drawing(&scene.camera(self.effort.picture)?, technique, shading)?;
        let software = scene.features().is_software();
        let repeats = Repetition::of(lifetime, software, self.effort.warm_up, count);
        let repeats = if self.effort.is_choice() { repeats.of_choice(software) } else { repeats };
        let is_timed_whole = is_timed_whole(scene, lifetime);
        let mut watch = Watch::begin(&self.clock);
        let mut looked = 0;
        // A device with nothing to build, for example when only the camera moves, is idle: its clock then means nothing.
        let works = Cell::new(false);
        let slow = Cell::new(false);
        let is_slow = || {
            slow.set(works.get() && self.clock.is_slow());
            slow.get()
        };
        let builds = repeats.run(is_slow, |frame, is_timed| {
            let moved = scene.show(frame % scene.frames.count())?;
            let build = build_times(scene, technique, is_timed_whole)?;
            works.set(!build.each.passes.is_empty());
            // Reading the clock takes longer than many builds do, so a few times are enough. The clock during warm-up is not counted.
            if is_timed && works.get() && frame * LOOKS >= looked * count {
                looked += 1;
                watch.look();
            }
            Ok((moved, build, drawing.as_ref().map(Drawing::draw).transpose()?))
        })?;
        if slow.get() {
            self.clock.give_up();
        }
        let mut timed = BuildSamples::default();
        timed.built.clock = scene.context.calibrate();
        for (moved, build, drawn) in builds {
            timed.moves.extend((!moved.is_empty()).then_some(moved));
            timed.built.builds.push(build);
            timed.draws.extend(drawn);
        }
        let (device, host) = (device_ns(scene, &timed, lifetime), timed.host_ns());
        timed.steadiness = watch.end(Timing::of(if device.is_empty() { &host } else { &device }));
        Ok(timed)
    }

    /// Times look-ups at the same points, one pass after another.
    pub fn time_lookups(&self, scene: &DeviceScene, technique: &dyn Technique) -> Result<Vec<LookupTimes>> {
        let batches = self.points.iter().enumerate().map(|(light, points)| PointBatch { light, points, normals: &[] });
        let query = Query::of_lights(scene.context, &batches.collect::<Vec<_>>())?;
        let kernel = query.kernel(&technique.answer())?;
        let ask = || query.query(&kernel).map(|time| time.into_iter().collect());
        // If nothing was built, the device has been idle until now.
        let start = Instant::now();
        query.query(&kernel)?;
        while start.elapsed() < SLOW_WARM_UP && self.clock.is_slow() {
            query.query(&kernel)?;
        }
        let software = scene.features().is_software();
        let mut samples = Vec::new();
        let start = Instant::now();
        for frame in 0..self.effort.frames {
            // On a software device, techniques that store lists take seconds per million look-ups.
            if are_enough(frame, start.elapsed(), LOOKUP_BUDGET, software) {
                break;
            }
            samples.push(LookupTimes { ran: TimedRun::passes(ask)?, points: query.points() });
        }
        Ok(samples)
    }

    /// Times each drawing of a picture, including the sorting of its casters, as in a moving world. The first drawings warm up; on a GPU
    /// they continue until the GPU reaches its clock rate, and each is drawn once more with a single timestamp pair around all passes. If
    /// the first timed drawing uses up the budget, no more follow, except those that a picture needs until it no longer changes.
    pub fn time_draws(
        &self,
        scene: &DeviceScene,
        shading: Shading,
        renderer: &Renderer,
        kernels: &Kernels,
    ) -> Result<DrawTimes> {
        let software = scene.features().is_software();
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
            scene.context.time_passes(false);
            let whole = draw();
            scene.context.time_passes(true);
            Ok((each, frame_ns(&whole?)))
        };
        let mut start = Instant::now();
        let mut samples = vec![sample()?];
        // A GPU has been idle while the host computed the truth.
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

    /// Times pictures without shadows, drawn with `none` in the same way as a row's pictures.
    pub fn time_unshadowed(
        &self,
        scene: &DeviceScene,
        none: &Opened,
        settings: PictureSettings,
    ) -> Result<Option<Timing>> {
        let camera = scene.camera(self.effort.picture)?;
        if let Some(drawing) = scene.drawing(&camera, none, settings.shading)? {
            let frames = (0..self.effort.frames.max(1)).map(|_| drawing.draw()).collect::<Result<Vec<_>>>()?;
            let draws_ns: Vec<f64> = frames.iter().filter_map(|passes| frame_ns(passes)).collect();
            return Ok(Timing::of(&draws_ns));
        }
        let renderer = scene.renderer(&camera, settings)?;
        let kernels = renderer.kernels_of(none.technique.as_ref(), settings.shading, settings.lighting)?;
        Ok(Timing::of(&self.time_draws(scene, settings.shading, &renderer, &kernels)?.counted_ns))
    }
}

/// Whether builds are also timed as a whole. A software device waits between passes either way. A bake takes long. In a moving world, a
/// second build of the same frame would find its views and orders already computed.
fn is_timed_whole(scene: &DeviceScene, lifetime: Lifetime) -> bool {
    !scene.features().is_software() && lifetime == Lifetime::Frame && scene.is_still()
}

/// Builds once, or twice if the build is also timed as a whole. If frames differ, only the passes that depend on what has moved run; if all
/// frames are alike, all passes do.
fn build_times(scene: &DeviceScene, technique: &mut Opened, is_timed_whole: bool) -> Result<BuildTimes> {
    let (more, world) = (scene.has_frames(), &scene.world);
    let each = TimedRun::of(|| if more { technique.build(world) } else { technique.rebuild(world) })?;
    let mut whole = None;
    if is_timed_whole {
        scene.context.time_passes(false);
        let again = TimedRun::of(|| technique.rebuild(world));
        scene.context.time_passes(true);
        whole = Some(again?);
    }
    Ok(BuildTimes { each, whole })
}

/// Returns the device time of each build. A build without passes took no time: nothing that the technique depends on had moved, or the
/// technique builds nothing. For a baked technique in a static world, such a build has no time, since the technique was baked before.
pub(in crate::bench) fn device_ns(scene: &DeviceScene, timed: &BuildSamples, lifetime: Lifetime) -> Vec<f64> {
    let is_built = scene.has_frames() || lifetime == Lifetime::Frame;
    let has_times = is_built && scene.features().timestamp_valid_bits > 0;
    let of = |passes: &Vec<PassTime>| frame_ns(passes).or((has_times && passes.is_empty()).then_some(0.0));
    timed.built.builds.iter().map(|build| &build.counted().passes).filter_map(of).collect()
}

/// Returns techniques and paths that have rows with a slow first build, if it was no slower than the later builds in any such row.
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

    /// A path must be learned from rows with slow first builds, unless the first build of any of these rows was slower than the later ones.
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
