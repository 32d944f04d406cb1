//! Compares the arithmetic throughput of fragment shaders with that of compute shaders. On data-centre GPUs, vertices and fragments run on
//! only a few of the processors, so drawing takes many times as long as on a GPU for graphics.

use crate::Result;
use crate::bench::{PassTiming, Row, Status, Timing};
use crate::gpu::{
    Blend, Buffer, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Memory, Target, push_struct,
};
use crate::shaders::{bench, set, shading};
use crate::technique::{Lifetime, REGISTRY};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A device is lopsided if fragments take more than this many times as long as compute threads. Software drivers take 0.6 to 1.1 times as
/// long, and an H100, which draws on 4 of its 132 processors, 33 times.
const LOPSIDED: f64 = 4.0;

/// Largest fraction of raster work in a row's time at which that time still counts on a lopsided device.
const MOST_RASTER: f64 = 0.25;

/// Side of the square of threads or fragments. A software device uses a smaller square but runs longer, since it has some overhead per
/// fragment.
const SIDE: u32 = 1024;
const SIDE_ON_CPU: u32 = 512;

/// Target time of the compute threads, in nanoseconds.
const COMPUTE_NS: f64 = 1e6;
const COMPUTE_NS_ON_CPU: f64 = 12e6;

/// Threads per workgroup. Twin: local_size_x in glsl/bench/in_compute.comp.
const THREADS: u32 = 128;

/// Number of rounds in the first run, from whose time the number of rounds is chosen.
const FIRST_ROUNDS: u32 = 32;
/// Maximum number of rounds: lavapipe 22.3 ends loops after about 65,536.
const MOST_ROUNDS: u32 = 1 << 15;

/// Number of calibration runs that choose the number of rounds: a GPU that has idled executes the first of them at a low clock.
const CHOICES: usize = 3;

/// Number of timed runs; the median counts.
const SAMPLES: u32 = 5;

push_struct! {
    /// Twin: ArithmeticPush in glsl/bench/arithmetic.glsl.
    struct ArithmeticPush {
        seed: u32,
        rounds: u32,
        width: u32,
    }
}

/// Fragment-shader arithmetic throughput of a device, compared with compute shaders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageRates {
    /// Device time of the same arithmetic in fragments, divided by its time in a compute shader.
    pub fragment_slowdown: f64,
    /// Number of processors on which fragments ran. Absent if the device does not report it (VK_NV_shader_sm_builtins).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fragment_processors: Option<u32>,
    /// Number of processors on which compute threads ran. Absent if the device does not report it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processors: Option<u32>,
}

impl StageRates {
    /// Whether fragments are so slow that a time with much raster work says nothing about other devices.
    pub fn is_lopsided(&self) -> bool {
        self.fragment_slowdown > LOPSIDED
    }

    /// Formats it as `fragments run on 4 of 132 processors, 33 times slower`, without a full stop.
    pub fn sentence(&self) -> String {
        let times = times(self.fragment_slowdown);
        match (self.is_lopsided(), self.place()) {
            (true, Some(place)) => format!("fragments run {place}, {times} times slower"),
            (true, None) => format!("fragments are {times} times slower than compute"),
            (false, Some(place)) => format!("fragments run {place}, and take {times} times as long as compute"),
            (false, None) => format!("fragments take {times} times as long as compute"),
        }
    }

    /// Formats `on 4 of 132 processors`.
    fn place(&self) -> Option<String> {
        let (few, all) = self.fragment_processors.zip(self.processors)?;
        Some(if few == all { format!("on all {all} processors") } else { format!("on {few} of {all} processors") })
    }
}

fn times(value: f64) -> String {
    if value < 9.95 { format!("{value:.1}") } else { format!("{value:.0}") }
}

/// Runs the same arithmetic in as many fragments as compute threads, for some milliseconds, and compares their times. `None` if the device
/// has no timestamps.
///
/// # Errors
/// [`crate::Error::Gpu`] if memory runs out or the device is lost; [`crate::Error::Refused`] on an adopted device.
pub fn stage_rates(context: &Context) -> Result<Option<StageRates>> {
    let features = context.features();
    if features.timestamp_valid_bits == 0 {
        return Ok(None);
    }
    let (side, wanted_ns) = if features.is_software() { (SIDE_ON_CPU, COMPUTE_NS_ON_CPU) } else { (SIDE, COMPUTE_NS) };
    let stages = StageArithmetic::new(context, side, false)?;
    let Some(rounds) = rounds(&stages, wanted_ns)? else { return Ok(None) };
    let mut ratios = Vec::new();
    for seed in 0..SAMPLES {
        ratios.extend(stages.run(seed, rounds)?.map(|[compute_ns, fragments_ns]| fragments_ns / compute_ns.max(1.0)));
    }
    let mut found = [None; 2];
    if features.shader_sm_builtins {
        let stages = StageArithmetic::new(context, side, true)?;
        stages.run(0, rounds)?;
        let count = |values: Vec<[u32; 2]>| values.iter().map(|value| value[1]).collect::<BTreeSet<_>>().len() as u32;
        found = stages.read()?.map(|values| Some(count(values)));
    }
    let [processors, fragment_processors] = found;
    Ok(Timing::of(&ratios).map(|ratio| StageRates { fragment_slowdown: ratio.median, fragment_processors, processors }))
}

/// Returns how many rounds the compute threads complete in about the requested time. The runs also warm up the device.
fn rounds(stages: &StageArithmetic, wanted_ns: f64) -> Result<Option<u32>> {
    // Drivers finish building a pipeline when it first runs.
    stages.run(0, 1)?;
    let mut rounds = FIRST_ROUNDS;
    for _ in 0..CHOICES {
        let Some([compute_ns, _]) = stages.run(0, rounds)? else { return Ok(None) };
        let next = f64::from(rounds) * wanted_ns / compute_ns.max(1.0);
        rounds = next.clamp(f64::from(FIRST_ROUNDS), f64::from(MOST_ROUNDS)) as u32;
    }
    Ok(Some(rounds))
}

/// The arithmetic in both stages: one compute thread and one fragment per point of a square.
pub struct StageArithmetic {
    context: Context,
    side: u32,
    compute: Kernel<ArithmeticPush>,
    fragments: Kernel<ArithmeticPush>,
    computed: Buffer,
    drawn: Image,
}

impl StageArithmetic {
    /// Creates a square of `side` × `side` threads, and as many fragments; `side` is a multiple of 16. With `processors`, each also reports
    /// which processor it ran on; this requires [`crate::gpu::Features::shader_sm_builtins`].
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out or the driver rejects a shader.
    pub fn new(context: &Context, side: u32, processors: bool) -> Result<Self> {
        let (compute, fragment) = match processors {
            false => (&bench::IN_COMPUTE_PROCESSORS_0, &bench::IN_FRAGMENTS_FRAG_PROCESSORS_0),
            true => (&bench::IN_COMPUTE_PROCESSORS_1, &bench::IN_FRAGMENTS_FRAG_PROCESSORS_1),
        };
        let bytes = size_of::<[u32; 2]>() as u64 * u64::from(side) * u64::from(side);
        let computed = Buffer::new(context, "in-compute", bytes, Memory::Device)?;
        let drawn = Image::new(context, "in-fragments", Format::R32G32_UINT, [side; 2], ImageUse::Color)?;
        let bindings = set::InCompute { values: &computed }.bind(context, "in-compute")?;
        let state = Graphics {
            vertex: &shading::FULLSCREEN_VERT,
            fragment,
            colors: &[(Format::R32G32_UINT, Blend::None)],
            depth: None,
        };
        Ok(Self {
            context: context.clone(),
            side,
            compute: Kernel::compute(context, compute, &[&bindings], &Constants::new())?,
            fragments: Kernel::graphics(context, &state, &[], &Constants::new())?,
            computed,
            drawn,
        })
    }

    /// Runs the arithmetic in compute threads, then in fragments. Returns nanoseconds in compute and in fragments, or `None` if the device
    /// has no timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn run(&self, seed: u32, rounds: u32) -> Result<Option<[f64; 2]>> {
        let push = ArithmeticPush { seed, rounds, width: self.side };
        let passes = self.context.submit(|commands| {
            let groups = [self.side * self.side / THREADS, 1, 1];
            commands.pass("bench.in_compute", |pass| pass.dispatch(&self.compute, &push, groups));
            commands.pass("bench.in_fragments", |pass| {
                let colors = [Target { image: &self.drawn, clear: None }];
                pass.render([self.side; 2], &colors, None, |draw| draw.draw(&self.fragments, &push, 3, 1));
            });
        })?;
        Ok(match &passes[..] {
            [compute, fragments] => Some([compute, fragments].map(|pass| pass.end_ns - pass.start_ns)),
            _ => None,
        })
    }

    /// Returns the output of compute threads and fragments in the last run, row by row: the value, and the processor that computed it, or 0
    /// if processors are not reported.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out or the device is lost.
    pub fn read(&self) -> Result<[Vec<[u32; 2]>; 2]> {
        Ok([self.computed.read((self.side * self.side) as usize)?, self.drawn.read()?])
    }
}

/// Returns reasons not to compare a row's times: on a lopsided device, more than a quarter of the time of its passes is raster work. Only
/// passes in the frame time count: build and picture, or the picture alone for a bake in a static world.
pub fn marks(row: &Row, stages: Option<&StageRates>) -> Vec<String> {
    let Some(stages) = stages.filter(|stages| stages.is_lopsided() && row.status == Status::Ok) else {
        return Vec::new();
    };
    let passes = its_build(row).chain(&row.draw_passes);
    let share = raster_share(passes).filter(|share| *share > MOST_RASTER);
    let place =
        stages.place().unwrap_or_else(|| format!("{} times slower than compute", times(stages.fragment_slowdown)));
    share.map(|share| format!("{:.0} % raster work, {place}", 100.0 * share)).into_iter().collect()
}

/// Returns the device time of a build and a million look-ups, in nanoseconds: compute shaders do both, on all processors of any device. For
/// a bake in a static world it covers look-ups alone. `None` if more than a quarter of the build is raster work, or if no look-ups were
/// timed.
pub fn compute_ns(row: &Row) -> Option<f64> {
    let build_ns = if is_baked_before(row) { 0.0 } else { row.build_ns?.median };
    let is_computed = raster_share(its_build(row)).is_none_or(|share| share <= MOST_RASTER);
    is_computed.then_some(build_ns + row.lookup_ns_per_million?.median)
}

/// Returns the passes of a build that count towards the frame time.
fn its_build(row: &Row) -> impl Iterator<Item = &PassTiming> {
    let moves = |pass: &&PassTiming| pass.name == "world.move" || pass.name.starts_with("simulate.");
    row.passes.iter().filter(move |pass| !moves(pass) && !is_baked_before(row))
}

/// Returns the fraction of the passes' total time that is raster work; `None` if no pass took any time.
fn raster_share<'a>(passes: impl Iterator<Item = &'a PassTiming>) -> Option<f64> {
    let (mut raster_ns, mut all_ns) = (0.0, 0.0);
    for pass in passes {
        all_ns += pass.median_ns;
        raster_ns += if pass.raster == Some(true) { pass.median_ns } else { 0.0 };
    }
    (all_ns > 0.0).then_some(raster_ns / all_ns)
}

/// Whether the build is not part of a frame: a bake in a static world.
fn is_baked_before(row: &Row) -> bool {
    let is_baked = REGISTRY.iter().any(|entry| entry.name == row.technique && entry.lifetime == Lifetime::Baked);
    is_baked && row.frame_ns == row.draw_ns.map(|draw| draw.median)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEW: StageRates = StageRates { fragment_slowdown: 32.9, fragment_processors: Some(4), processors: Some(132) };

    fn pass(name: &str, ns: f64, raster: bool) -> PassTiming {
        PassTiming { name: name.into(), median_ns: ns, p05_ns: ns, p95_ns: ns, raster: Some(raster) }
    }

    /// Returns a row with a build in compute, and a picture that takes 40 ns, `raster` of them in raster work.
    fn row(technique: &str, raster: f64) -> Row {
        Row {
            technique: technique.into(),
            passes: vec![pass("build", 60.0, false)],
            draw_passes: vec![pass("picture", raster, true), pass("tonemap", 40.0 - raster, false)],
            ..Row::default()
        }
    }

    #[test]
    fn a_row_is_marked_by_more_than_a_quarter_of_raster_work() {
        assert_eq!(marks(&row("avsm", 24.0), Some(&FEW)), [""; 0]);
        assert_eq!(marks(&row("avsm", 25.0), Some(&FEW)), [""; 0]);
        assert_eq!(marks(&row("avsm", 26.0), Some(&FEW)), ["26 % raster work, on 4 of 132 processors"]);
        let untold = StageRates { fragment_processors: None, processors: None, ..FEW };
        assert_eq!(marks(&row("avsm", 26.0), Some(&untold)), ["26 % raster work, 33 times slower than compute"]);
        // Raster work in a build counts as much.
        let mut drawn = row("avsm", 0.0);
        drawn.passes[0].raster = Some(true);
        assert_eq!(marks(&drawn, Some(&FEW)), ["60 % raster work, on 4 of 132 processors"]);
    }

    /// Checks the time of a build in compute and a million look-ups; there must be none if the build is raster work.
    #[test]
    fn what_compute_takes() {
        let timing = |ns| Timing::of(&[ns]);
        let of = |raster| Row {
            passes: vec![
                pass("avsm.resolve", 3.0, false),
                pass("maps.opaque", 1.0, raster),
                pass("world.move", 9.0, true),
            ],
            build_ns: timing(4.0),
            lookup_ns_per_million: timing(2.0),
            ..row("avsm", 100.0)
        };
        assert_eq!(compute_ns(&of(true)), Some(6.0));
        let drawn =
            Row { passes: vec![pass("psm.voxelize", 3.0, true), pass("psm.propagate", 6.0, false)], ..of(true) };
        assert_eq!(compute_ns(&drawn), None);
        assert_eq!(compute_ns(&Row { lookup_ns_per_million: None, ..of(false) }), None);
    }

    #[test]
    fn other_rows_and_devices_have_no_marks() {
        let even = StageRates { fragment_slowdown: 1.1, fragment_processors: Some(132), ..FEW };
        assert_eq!(marks(&row("avsm", 40.0), Some(&even)), [""; 0]);
        assert_eq!(marks(&row("avsm", 40.0), None), [""; 0]);
        assert_eq!(marks(&Row::default(), Some(&FEW)), [""; 0]);
        assert_eq!(marks(&Row { status: Status::Failed, ..row("avsm", 40.0) }, Some(&FEW)), [""; 0]);
        // Older files do not record which passes drew.
        let mut old = row("avsm", 40.0);
        old.draw_passes.iter_mut().for_each(|pass| pass.raster = None);
        assert_eq!(marks(&old, Some(&FEW)), [""; 0]);
    }

    /// Passes that move the world before a build, and a bake in a static world, are not part of a frame, so they must not count as its
    /// raster work.
    #[test]
    fn what_is_in_no_frame_does_not_count() {
        let mut moving = row("avsm", 24.0);
        moving.passes.insert(0, pass("world.move", 1000.0, true));
        moving.passes.insert(0, pass("simulate.step", 1000.0, false));
        assert_eq!(marks(&moving, Some(&FEW)), [""; 0]);
        moving.draw_passes[0].median_ns = 26.0;
        assert_eq!(marks(&moving, Some(&FEW)).len(), 1);
        let draw_ns = Timing::of(&[40.0]);
        let baked = Row { frame_ns: Some(40.0), draw_ns, ..row("voxelized", 20.0) };
        assert_eq!(marks(&baked, Some(&FEW)), ["50 % raster work, on 4 of 132 processors"]);
        let baked_again = Row { frame_ns: Some(100.0), ..baked };
        assert_eq!(marks(&baked_again, Some(&FEW)), [""; 0]);
    }

    #[test]
    fn a_device_is_told_in_one_sentence() {
        assert_eq!(FEW.sentence(), "fragments run on 4 of 132 processors, 33 times slower");
        let untold = StageRates { fragment_processors: None, ..FEW };
        assert_eq!(untold.sentence(), "fragments are 33 times slower than compute");
        let even = StageRates { fragment_slowdown: 0.94, fragment_processors: None, processors: None };
        assert_eq!(even.sentence(), "fragments take 0.9 times as long as compute");
        let all = StageRates { fragment_slowdown: 1.0, fragment_processors: Some(28), processors: Some(28) };
        assert_eq!(all.sentence(), "fragments run on all 28 processors, and take 1.0 times as long as compute");
        assert!(FEW.is_lopsided() && untold.is_lopsided() && !even.is_lopsided() && !all.is_lopsided());
    }
}
