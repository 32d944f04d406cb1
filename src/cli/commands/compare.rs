//! `gobo compare`

use crate::bench::{
    self, DeviceFacts, Effort, Extent, Frames, LOOKUPS, Plan, PlannedScene, Results, Traced, copy_bytes_per_second,
    stage_rates,
};
use crate::cli::baseline::{Baseline, BaselineArguments};
use crate::cli::compared_frames::{Compared, name_apart};
use crate::cli::default_specs::{all_specs, usual_specs};
use crate::cli::output::exit_code::exit_code;
use crate::cli::output::writer::Writer;
use crate::cli::resume::{SCENE, files, kept};
use crate::cli::{
    DeviceArguments, LoadArguments, MovingArgument, Span, VplArgument, check_messages, command_line, load, picture,
    say, test_reduction,
};
use crate::gpu::{Context, Features};
use crate::report::{Store, answers, casters, counts, footprints, page, passes, plots, table, trace, write_whole};
use crate::scene::Scene;
use crate::technique::{Name, Spec};
use crate::{Error, Result};
use clap::{Args, ValueEnum};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Number of timed frames; fewer on a software device with a static world, whose times are only good for ratios and whose builds take a
/// hundred times as long.
const FRAMES: u32 = 30;
const SOFTWARE_FRAMES: u32 = 8;

/// Size in pixels of a picture in a quick look, and on a software device if no technique is named.
pub(in crate::cli) const SMALL_PICTURE: [u32; 2] = [320, 180];

#[derive(Args)]
pub struct Arguments {
    /// Scene files, data files or built-in scenes [default: three-emitters]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Technique spec, repeatable [default: each technique once, and AVSM by each path that the device supports]
    #[arg(long = "technique", value_name = "SPEC")]
    techniques: Vec<String>,
    /// Compare all specs that the device can run: nodes, samples, moments and paths of each technique; under many lights, grids in all
    /// sizes and shadings
    #[arg(long, conflicts_with = "techniques")]
    all: bool,
    /// Folder for results.json, results.csv, pictures, plots and report.html
    #[arg(long, default_value = "gobo-report", value_name = "DIR")]
    out: PathBuf,
    /// Continue where an earlier run of the same command ended: keep the rows in the folder, measure those that failed or are missing
    #[arg(long)]
    resume: bool,
    /// Measure the I-th of N shards of the rows, in its own folder; gobo join combines them
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<[usize; 2]>,
    /// Timed frames per row; with --moving, number of frames that the world moves through
    /// [default: 30; 8 on a software device if the world is static]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// A quick look: 8 frames, an eighth of the space points, a quarter of the picture
    #[arg(long)]
    quick: bool,
    /// Build everything, even parts that no look-up reads or that have not changed: skip=off for every technique
    #[arg(long)]
    no_skip: bool,
    /// Also print the time of each pass of a build, and a build's time as a multiple of copying the bytes it leaves behind
    #[arg(long)]
    passes: bool,
    /// Also print what each pass did, in one more build and picture: vertices and primitives read, fragments and threads run
    #[arg(long)]
    pipeline_statistics: bool,
    /// Write all timed builds, look-ups and pictures, pass by pass, as trace events for Perfetto and Chrome
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Also print errors on surfaces in the shadow of meshes, by the mesh's distance from the light and from the
    /// surface
    #[arg(long, conflicts_with = "no_truth")]
    casters: bool,
    /// Also print errors against the mean of the truth over squares of 1/4 to 16 texels of a 256² map: a pixel sees such a mean if hair is
    /// thinner than it
    #[arg(long, conflicts_with = "no_truth")]
    footprints: bool,
    /// Size of the pictures in pixels, up to 16384 per side [default: 640x360, or 320x180 for a quick look]
    #[arg(long, value_name = picture::VALUE, value_parser = picture::size)]
    picture: Option<[u32; 2]>,
    /// Turn the camera around its target by this many degrees over the frames, and compare 16 consecutive pictures with the truth
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, conflicts_with = "no_truth", value_parser = degrees)]
    turn: Option<f64>,
    /// Map points: a fixed sample of the covered texels, whose standard error is stated, or all of them
    #[arg(long, value_enum, default_value = "sample")]
    truth: TruthArgument,
    /// Measure times only
    #[arg(long, conflicts_with = "truth")]
    no_truth: bool,
    #[command(flatten)]
    moving: MovingArgument,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    vpls: VplArgument,
    /// With --vpls: also compare pictures with one bounce of the scene's lights, path traced with this many directions per pixel
    #[arg(long, value_name = "SAMPLES", requires = "vpls", conflicts_with = "no_truth", value_parser = clap::value_parser!(u32).range(2..=65536))]
    bounce: Option<u32>,
    #[command(flatten)]
    baseline: BaselineArguments,
    /// Print JSON instead of tables: the same figures, not rounded
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    device: DeviceArguments,
}

impl Arguments {
    /// With `GOBO_TEST_LITTLE`, returns a smaller version of the command.
    pub fn little(mut self) -> Self {
        if test_reduction::is_asked() {
            let frames = self.frames.map_or(2, |frames| frames.min(2));
            (self.frames, self.quick, self.picture) = (Some(frames), true, Some([32, 18]));
            self.vpls.vpls = self.vpls.vpls.map(|count| count.min(64));
            self.bounce = self.bounce.map(|samples| samples.min(2));
        }
        self
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum TruthArgument {
    Sample,
    Full,
}

fn shard(text: &str) -> std::result::Result<[usize; 2], String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some([i.parse().ok()?, n.parse().ok()?]));
    numbers.filter(|[i, n]| (1..=*n).contains(i)).ok_or_else(|| "give 1/4, say: the first of four".into())
}

fn degrees(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|d: &f64| d.abs() <= 360.0).ok_or_else(|| "give degrees, at most 360 either way".into())
}

/// Returns the number of seen points queried: fewer in a quick look, and on a software device, whose look-ups take a thousand times as
/// long.
pub(in crate::cli) fn seen_points(quick: bool, software: bool) -> usize {
    65536 / if software { 4 } else { 1 } / if quick { 4 } else { 1 }
}

fn effort(arguments: &Arguments, features: &Features) -> Effort {
    let software = features.is_software();
    let is_still = !arguments.moving.is_given() && arguments.turn.is_none();
    let frames = arguments.frames.unwrap_or(if software && is_still { SOFTWARE_FRAMES } else { FRAMES }) as usize;
    // On a GPU all look-ups are timed: an eighth of them would be too short to time. A software device may take seconds for that many.
    let lookups = LOOKUPS / if software { 8 } else { 1 };
    let truth = match (arguments.no_truth, arguments.truth) {
        (true, _) => Extent::None,
        (false, TruthArgument::Sample) => Extent::Sample,
        (false, TruthArgument::Full) => Extent::Full,
    };
    let (turning, footprints, counts) = (arguments.turn.is_some(), arguments.footprints, arguments.pipeline_statistics);
    if arguments.quick {
        let picture = arguments.picture.unwrap_or(SMALL_PICTURE);
        return Effort {
            frames: frames.min(8),
            warm_up: if test_reduction::is_asked() { 0 } else { 2 },
            space_points: 8192,
            seen_points: if test_reduction::is_asked() { test_reduction::SEEN } else { seen_points(true, software) },
            lookups: if test_reduction::is_asked() { test_reduction::LOOKUPS } else { lookups },
            picture,
            turning,
            footprints,
            counts,
            truth,
        };
    }
    let small = arguments.techniques.is_empty() && software;
    let picture = arguments.picture.unwrap_or(if small { SMALL_PICTURE } else { [640, 360] });
    // A software device has no clock rate to reach, and the row's first build has already made room for everything.
    let warm_up = if software { 0 } else { 5 };
    let seen_points = seen_points(false, software);
    let space_points = if small { 16384 } else { 65536 };
    Effort { frames, warm_up, space_points, seen_points, lookups, picture, turning, footprints, counts, truth }
}

/// Returns the scene in each frame, and the times of these frames. Without a truth to compare with, one frame of a simulated scene is
/// enough, since the device moves it. Frames of a sequence of files are read when they are shown.
fn frames(arguments: &Arguments, name: &str) -> Result<Compared> {
    let scene = load(name, &arguments.load)?;
    let frames = arguments.frames.unwrap_or(FRAMES);
    let times_s = arguments.moving.times(&scene, frames)?;
    if arguments.no_truth && scene.fountain().is_some() && !arguments.vpls.is_given() {
        return Ok(Compared::held(vec![scene.scene], times_s, scene.animation));
    }
    if arguments.turn.is_some() && frames < 2 {
        return Err(Error::usage("--frames", "a camera turns from one frame to another", "give 2 or more"));
    }
    let step_degrees = arguments.turn.map(|degrees| degrees / f64::from(frames - 1));
    if scene.is_read() && arguments.moving.is_given() && !arguments.vpls.is_given() {
        return Compared::read(scene, times_s, step_degrees);
    }
    let animation = scene.animation.clone();
    let mut states = arguments.moving.states(scene, frames)?;
    if let Some(step_degrees) = step_degrees {
        states.resize(frames as usize, states[0].clone());
        for (frame, scene) in states.iter_mut().enumerate() {
            scene.camera = scene.camera.turned(step_degrees * frame as f64);
        }
    }
    Ok(Compared::held(states, times_s, animation))
}

/// With `--bounce`, returns each scene in its last frame, under its own lights.
fn bounced(arguments: &Arguments, scenes: &[Compared]) -> Result<Vec<Scene>> {
    if arguments.bounce.is_none() {
        return Ok(Vec::new());
    }
    let last = scenes.iter().filter_map(|compared| compared.states.last());
    let with_meshes = |scene: &Scene| match scene.has_only_meshes() {
        true => Ok(scene.clone()),
        false => {
            let cause = "it has smoke or hair, and --bounce traces meshes alone";
            Err(Error::input(scene.name.clone(), cause, "leave --bounce out"))
        }
    };
    last.map(with_meshes).collect()
}

/// Returns the named specs or, if there are none, the scene's usual ones.
fn specs(arguments: &Arguments, named: &[Spec], scene: &Scene, features: &Features) -> Result<Vec<Spec>> {
    let mut specs = match (named.is_empty(), arguments.all) {
        (true, true) => test_reduction::specs(all_specs(scene, features, false)?),
        (true, false) => test_reduction::specs(usual_specs(scene, features)?),
        _ => named.to_vec(),
    };
    if arguments.no_skip {
        specs.iter_mut().for_each(|spec| spec.set(Name::SKIP, "off"));
    }
    Ok(specs)
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let scene_names =
        if arguments.scenes.is_empty() { vec!["three-emitters".to_owned()] } else { arguments.scenes.clone() };
    // All input errors are found before the first measurement.
    let mut named: Vec<Spec> = Vec::new();
    for text in &arguments.techniques {
        named.extend(test_reduction::specs(crate::cli::specs(text)?));
    }
    let mut scenes = scene_names.iter().map(|name| frames(arguments, name)).collect::<Result<Vec<_>>>()?;
    test_reduction::first(&mut scenes, 1);
    arguments.vpls.check(scenes.iter().flat_map(|compared| &compared.states))?;
    let baseline = arguments.baseline.read()?;
    let fingerprints: Vec<u32> = scenes.iter().map(Compared::fingerprint).collect();
    let bounced = bounced(arguments, &scenes)?;
    let context = arguments.device.open()?;
    for compared in &mut scenes {
        arguments.vpls.light(&context, &mut compared.states)?;
    }
    name_apart(&mut scenes);
    let features = context.features();
    let reads: Vec<_> = scenes.iter().map(|compared| move |frame| compared.at(frame)).collect();
    let mut planned = Vec::new();
    for (i, (compared, read)) in scenes.iter().zip(&reads).enumerate() {
        let bounce = bounced.get(i).zip(arguments.bounce).map(|(scene, samples)| Traced { scene, samples });
        // Under virtual lights the host moves the scene.
        let fountain = compared.fountain().filter(|_| !arguments.vpls.is_given());
        let frames = Frames { states: compared.states(read), times_s: &compared.times_s, fountain, bounce };
        planned.push(PlannedScene { frames, specs: specs(arguments, &named, compared.first(), features)? });
    }
    if arguments.pipeline_statistics && !features.pipeline_statistics_query {
        return Err(Error::Refused("pipelineStatisticsQuery, for --pipeline-statistics".into()));
    }
    let effort = effort(arguments, features);
    let mut plan = Plan::new(effort, planned);
    // On a software device, and if the driver reports on its pipelines, each row creates its own. A software driver compiles a pipeline
    // when it first draws, so creating it early gains nothing; and the driver's reports must come in the order of the rows.
    plan.makes_pipelines_first = !features.is_software() && !arguments.pipeline_statistics;
    plan.baseline = baseline.before();
    let mut conditions = conditions(arguments, &effort);
    let print =
        |(compared, print): (&Compared, u32)| (format!("{SCENE}{}", compared.first().name), format!("{print:08x}"));
    conditions.extend(scenes.iter().zip(fingerprints).map(print));
    conditions.extend(files(plan.list().into_iter().map(|(_, spec)| spec)));
    let results = Results::new(command_line(), conditions, DeviceFacts::of(features));
    measure(arguments, &context, plan, results, &baseline)
}

/// Measures the rows that an earlier run lacks, then writes and prints all rows.
fn measure(
    arguments: &Arguments,
    context: &Context,
    mut plan: Plan,
    mut results: Results,
    baseline: &Baseline,
) -> Result<ExitCode> {
    context.ask_of_executables(arguments.pipeline_statistics);
    let store = Store::open(&arguments.out)?;
    baseline.check(&results)?;
    baseline.check_rows(&plan.list())?;
    results.shard = arguments.shard.map(|shard| plan.take_shard(shard));
    if arguments.resume {
        let kept = kept(store.dir(), &results, &plan.share())?;
        plan.keep(kept);
    }
    if arguments.passes {
        results.device.copy_bytes_per_second = copy_bytes_per_second(context)?;
    }
    results.device.stages = stage_rates(context)?;
    let mut writer = Writer::new(&store, plan.left(), arguments.trace.is_some());
    if plan.left() < plan.count() || plan.count() == 0 {
        results.rows = plan.measured();
        writer.write(|store| store.write(&results));
    }
    bench::run(context, &mut plan, &mut results, &mut writer)?;
    writer.progress.finish();
    let ended = writer.ended.take().map_or(Ok(()), Err);
    if results.rows.is_empty() && ended.is_err() {
        return ended.map(|()| ExitCode::FAILURE);
    }
    let code = report(arguments, writer, &results, baseline)?;
    if context.is_lost() {
        let way_out =
            "repeat the command with --resume; if it is lost again, leave the last row out, or update the driver";
        return Err(plan.lost(context).with_way_out(way_out));
    }
    ended.map(|()| code)
}

/// Writes and prints the measurements.
fn report(arguments: &Arguments, mut writer: Writer, results: &Results, baseline: &Baseline) -> Result<ExitCode> {
    let printed = if arguments.json { Ok(()) } else { print(arguments, results) };
    for (file, svg) in plots(results) {
        writer.write(|store| store.write_text(file, &svg));
    }
    writer.write(|store| store.write_text("report.html", &page(results, store.dir())?));
    if let Some(error) = writer.failed {
        return Err(error);
    }
    if let Some(path) = &arguments.trace {
        write_whole(path, trace(&results.device, &writer.traced.unwrap_or_default()).as_bytes())?;
    }
    printed?;
    let holds = baseline.finish(results, arguments.json)?;
    if !arguments.json {
        for answer in answers(results) {
            say(format!("\n{answer}"))?;
        }
        say(format!("\n{}", arguments.out.join("report.html").display()))?;
    }
    check_messages()?;
    let code = exit_code(results);
    Ok(if holds { code } else { ExitCode::FAILURE })
}

/// Prints the tables. This comes before plots and page are written, so that a full disk does not cost the output.
fn print(arguments: &Arguments, results: &Results) -> Result<()> {
    say(table(results))?;
    if arguments.passes {
        say(passes(results))?;
    }
    if arguments.pipeline_statistics {
        say(counts(results))?;
    }
    if arguments.casters {
        say(casters(results))?;
    }
    if arguments.footprints {
        say(footprints(results))?;
    }
    Ok(())
}

/// Returns the conditions that affect the figures, apart from specs and device.
fn conditions(arguments: &Arguments, effort: &Effort) -> BTreeMap<String, String> {
    let truth = effort.truth.word();
    let given = |value: Option<String>| value.unwrap_or_else(|| "none".into());
    let moving =
        arguments.moving.moving.map(|Span { from, to }| format!("{from}..{}", given(to.map(|to| to.to_string()))));
    [
        ("--frames", effort.frames.to_string()),
        // Files older than schema 3 lack this condition, and their errors leave out points.
        ("errors", "over all points".into()),
        ("--quick", arguments.quick.to_string()),
        ("seen points", effort.seen_points.to_string()),
        ("--picture", effort.picture.map(|side| side.to_string()).join("x")),
        ("--truth", truth.into()),
        ("--turn", given(arguments.turn.map(|degrees| degrees.to_string()))),
        ("--moving", given(moving)),
        ("--time", arguments.load.time.to_string()),
        ("--vpls", given(arguments.vpls.vpls.map(|count| count.to_string()))),
        ("--bounce", given(arguments.bounce.map(|samples| samples.to_string()))),
        ("--validation", arguments.device.validation.to_string()),
    ]
    .into_iter()
    // Older files lack these conditions, so they are listed only if they are on.
    .chain(effort.footprints.then(|| ("--footprints", "true".into())))
    .chain(arguments.vpls.follow_the_view().then(|| ("--vpls-by", "view".into())))
    .chain(effort.counts.then(|| ("--pipeline-statistics", "true".into())))
    .map(|(name, value)| (name.to_owned(), value))
    .collect()
}
