//! `gobo recommend`: finds the technique for a scene, from rows measured before or now.

use crate::bench::{
    self, DeviceFacts, Effort, Extent, LOOKUPS, Observer, Plan, PlannedScene, Results, Row, StageRates, stage_rates,
};
use crate::cli::candidates::{
    candidates, may_be_far, neighbours, one_of_each, one_of_each_shading, promising, shadings, with,
};
use crate::cli::commands::compare::{SMALL_PICTURE, seen_points};
use crate::cli::default_specs::{all_specs, has_many_lights, usual_specs, without_alike};
use crate::cli::output::progress::Progress;
use crate::cli::resume::{SCENE, kept};
use crate::cli::{DeviceArguments, LoadArguments, command_line, complain, load, say, say_json, test_reduction};
use crate::gpu::{Context, Features};
use crate::report::{Limits, Store, is_far, recommend};
use crate::scene::Scene;
use crate::technique::Spec;
use crate::{Error, Result};
use clap::Args;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Each pair is the number of timed frames and the number of warm-up frames before them. `COARSE_SOFTWARE` is for the first look on a
/// software device, which has no clock rate to reach and so needs no warm-up. `COARSE` is for the first look on other devices. `FINE` is
/// for the second look, at the remaining specs. `THOROUGH` is for `--thorough`, and the same as in `compare`.
const COARSE_SOFTWARE: [usize; 2] = [2, 0];
const COARSE: [usize; 2] = [3, 1];
const FINE: [usize; 2] = [10, 3];
const THOROUGH: [usize; 2] = [30, 5];

/// Maximum number of seen points in a first look.
const GLANCED: usize = 4096;

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    #[arg(value_name = "SCENE", required_unless_present = "from")]
    scene: Option<String>,
    /// Answer from rows that gobo compare has measured, without a device
    #[arg(long, value_name = "RESULTS.JSON", conflicts_with_all = ["scene", "many_lights", "out", "resume", "thorough", "quick", "lights", "device"])]
    from: Option<PathBuf>,
    /// Maximum milliseconds that shadows may add to a frame: the build, and the picture minus one without shadows
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    max_ms: Option<String>,
    /// Maximum seen error: the share of the picture's light that may be wrong
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    max_error: Option<String>,
    /// Maximum mean FLIP of the picture
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    max_flip: Option<String>,
    /// Maximum bytes of the look-up: 67108864 or 64MiB
    #[arg(long, value_name = "B", allow_hyphen_values = true)]
    max_bytes: Option<String>,
    /// Measure the techniques for many lights, however few lights the scene has
    #[arg(long)]
    many_lights: bool,
    /// Folder for the measured rows: results.json and results.csv, and those of the first look in its own folder
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue where an earlier run of the same command ended: keep the rows in the folder
    #[arg(long, requires = "out")]
    resume: bool,
    /// Measure every candidate in full, also at half and twice the size, without a first look: takes many times as long
    #[arg(long)]
    thorough: bool,
    /// A quick look for slow devices: 3 frames, a quarter of the points and of the picture; on a software device each technique once
    #[arg(long)]
    quick: bool,
    /// Print JSON instead of tables: the same figures, not rounded
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    device: DeviceArguments,
}

impl Arguments {
    /// With `GOBO_TEST_LITTLE`, returns a smaller version of the command, so small that no row needs to be left out.
    pub fn little(mut self) -> Self {
        if test_reduction::is_asked() && self.from.is_none() {
            (self.max_ms, self.max_error, self.max_flip, self.max_bytes) = (None, None, None, None);
        }
        self
    }

    fn limits(&self) -> Result<Limits> {
        Ok(Limits {
            ms: limit("--max-ms", self.max_ms.as_deref(), 1.0)?,
            error: limit("--max-error", self.max_error.as_deref(), 1.0)?,
            flip: limit("--max-flip", self.max_flip.as_deref(), 1.0)?,
            bytes: match self.max_bytes.as_deref() {
                None => None,
                Some(text) => {
                    let units = [
                        ("KiB", 1024.0),
                        ("MiB", 1_048_576.0),
                        ("GiB", 1_073_741_824.0),
                        ("KB", 1e3),
                        ("MB", 1e6),
                        ("GB", 1e9),
                    ];
                    let found = units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size)));
                    let (number, size) = found.unwrap_or((text, 1.0));
                    limit(&format!("--max-bytes {text}"), Some(number), size)?.map(|bytes| bytes as u64)
                }
            },
        })
    }
}

fn limit(option: &str, text: Option<&str>, unit: f64) -> Result<Option<f64>> {
    let Some(text) = text else { return Ok(None) };
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(Some(number * unit)),
        _ => {
            let name = if option.contains(' ') { option.to_owned() } else { format!("{option} {text}") };
            let units = if option.contains("bytes") { ", maybe with KiB, MiB, GiB, KB, MB or GB" } else { "" };
            Err(Error::usage(name, "not a valid limit", format!("give a number above 0{units}")))
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let limits = arguments.limits()?;
    let (results, name) = match (&arguments.from, &arguments.scene) {
        (Some(path), _) => (Results::read(path)?, path.display().to_string()),
        (None, Some(scene)) => (measured(arguments, &limits, scene)?, scene.clone()),
        (None, None) => return Err(Error::usage("recommend", "no scene", "name one, or give --from")),
    };
    let answers = recommend(&results, &limits);
    if answers.is_empty() {
        return Err(Error::input(name, "nothing is measured in it", "measure with gobo compare"));
    }
    if arguments.json {
        say_json(&answers.iter().filter_map(|answer| answer.as_ref().ok()).collect::<Vec<_>>())?;
    }
    let mut code = ExitCode::SUCCESS;
    for (place, answer) in answers.into_iter().enumerate() {
        match answer {
            Ok(_) if arguments.json => {}
            Ok(answer) if place > 0 => say(format!("\n{}", answer.text))?,
            Ok(answer) => say(answer.text)?,
            Err(why) => {
                complain(format!("gobo: {why}"));
                code = ExitCode::FAILURE;
            }
        }
    }
    Ok(code)
}

/// Measures the candidates. A first look takes one spec of each path of each technique that runs on the device for this scene, with few
/// repeats and few points, and then the other specs of techniques that are not far from the best. If no technique can be ruled out that
/// way, it takes every spec in one shading, and then the best specs in the other shadings. The specs that may be the answer are then
/// measured in full.
fn measured(arguments: &Arguments, limits: &Limits, name: &str) -> Result<Results> {
    let loaded = load(name, &arguments.load)?;
    let (fingerprint, scene) = (loaded.fingerprint(), loaded.scene);
    let context = arguments.device.open()?;
    let on_cpu = context.features().is_software();
    let specs = match arguments.quick && on_cpu && !arguments.many_lights {
        // Specs that take a software driver minutes are left out.
        true => usual_specs(&scene, context.features())?,
        false => {
            let all = all_specs(&scene, context.features(), arguments.many_lights)?;
            candidates(&scene, all, on_cpu, arguments.many_lights)?
        }
    };
    let specs = test_reduction::specs(specs);
    let stages = stage_rates(&context)?;
    let sweep = Sweep { arguments, scene: &scene, fingerprint, context: &context, stages };
    let work = Work::of(arguments.quick, stages.is_some_and(|stages| stages.is_lopsided()), context.features());
    if arguments.thorough {
        let near: Vec<Spec> = specs.iter().flat_map(neighbours).collect();
        return sweep.measure(&with(specs, near), work.effort(THOROUGH), arguments.out.as_deref(), &[]);
    }
    // Rows of the first look are kept too, so that a resumed run makes the same choice.
    let first = arguments.out.as_ref().map(|out| out.join("first-look"));
    let repeats = if context.features().is_software() { COARSE_SOFTWARE } else { COARSE };
    let specs = without_alike(&scene, specs);
    let coarse = work.coarse(repeats, limits);
    let many = arguments.many_lights || has_many_lights(&scene);
    let by_technique = may_be_far(&scene, limits, many);
    let (mut seen, others) = match (by_technique, limits.are_none()) {
        (true, _) => one_of_each(&specs),
        (false, true) => one_of_each_shading(&specs),
        // A spec that is slow in one shading may be within the limits in another.
        (false, false) => (specs, Vec::new()),
    };
    let mut rows = sweep.measure(&seen, coarse, first.as_deref(), &[])?.rows;
    let near = |spec: &&Spec| rows.iter().filter(|row| row.technique == spec.entry.name).any(|row| !is_far(row, &rows));
    let others: Vec<Spec> = match by_technique {
        true => others.iter().filter(near).cloned().collect(),
        false => shadings(&others, &seen, &rows),
    };
    let rest = first.map(|folder| folder.join("others"));
    // Results that an earlier run left there do not belong to this run.
    if let Some(rest) = rest.as_deref().filter(|rest| !arguments.resume && rest.is_dir()) {
        std::fs::remove_dir_all(rest).map_err(|cause| Error::output(rest, cause))?;
    }
    if !others.is_empty() {
        let more = sweep.measure(&others, coarse, rest.as_deref(), &rows)?.rows;
        rows.extend(more);
        seen.extend(others);
    }
    let left = promising(&seen, &rows, limits);
    // Only the errors by which rows are chosen are measured. On CPUs, the truth takes as long as a row.
    let whole = work.effort(FINE);
    let fine = Effort { truth: Extent::Choice, ..whole };
    sweep.measure(&left, fine, arguments.out.as_deref(), &rows)
}

/// How much to measure per row.
#[derive(Clone, Copy)]
struct Work {
    picture: [u32; 2],
    software: bool,
    /// Whether fragments run on few of the processors, in which case look-up times replace picture times.
    lopsided: bool,
    quick: bool,
}

impl Work {
    fn of(quick: bool, lopsided: bool, features: &Features) -> Self {
        let usual = if features.is_software() { SMALL_PICTURE } else { [640, 360] };
        let parts = if quick { 2 } else { 1 };
        let picture = if test_reduction::is_asked() { [32, 18] } else { usual.map(|side| side / parts) };
        Self { picture, quick, software: features.is_software(), lopsided }
    }

    /// Returns the effort with the points and the picture of `compare`.
    fn effort(self, repeats: [usize; 2]) -> Effort {
        let [frames, warm_up] = match (test_reduction::is_asked(), self.quick) {
            (true, _) => [1, 0],
            (_, true) => [repeats[0].min(3), repeats[1].min(1)],
            _ => repeats,
        };
        Effort {
            frames,
            warm_up,
            space_points: 0,
            seen_points: if test_reduction::is_asked() {
                test_reduction::SEEN
            } else {
                seen_points(self.quick, self.software)
            },
            lookups: if !self.lopsided {
                0
            } else if test_reduction::is_asked() {
                test_reduction::LOOKUPS
            } else {
                LOOKUPS
            },
            picture: self.picture,
            turning: false,
            footprints: false,
            counts: false,
            truth: Extent::Sample,
        }
    }

    /// Returns the effort of a first look. Pictures are drawn only if rows are chosen by them.
    fn coarse(self, repeats: [usize; 2], limits: &Limits) -> Effort {
        let truth = if limits.flip.is_some() { Extent::Choice } else { Extent::Glance };
        let whole = self.effort(repeats);
        Effort { seen_points: whole.seen_points.min(GLANCED), truth, ..whole }
    }
}

/// Measures specs of a scene.
struct Sweep<'a> {
    arguments: &'a Arguments,
    scene: &'a Scene,
    /// A checksum of the scene and its motion.
    fingerprint: u32,
    context: &'a Context,
    stages: Option<StageRates>,
}

impl Sweep<'_> {
    /// Measures a row per spec, after the rows `before`. Rows are stored in `folder` as soon as they are measured; with `--resume`, rows
    /// already there are kept.
    fn measure(&self, specs: &[Spec], effort: Effort, folder: Option<&Path>, before: &[Row]) -> Result<Results> {
        let scene = PlannedScene { frames: std::slice::from_ref(self.scene).into(), specs: specs.to_vec() };
        let mut plan = Plan::new(effort, vec![scene]);
        (plan.makes_pipelines_first, plan.earlier) = (true, before);
        let device = DeviceFacts { stages: self.stages, ..DeviceFacts::of(self.context.features()) };
        let mut results = Results::new(command_line(), self.conditions(&effort), device);
        let store = folder.map(Store::open).transpose()?;
        if let Some(store) = store.as_ref().filter(|_| self.arguments.resume) {
            let kept = kept(store.dir(), &results, &plan.share())?;
            plan.keep(kept);
        }
        let progress = Progress::new(plan.left());
        let mut recorder = Recorder { progress, store, context: self.context };
        bench::run(self.context, &mut plan, &mut results, &mut recorder)?;
        if self.context.is_lost() {
            return Err(plan.lost(self.context).with_way_out(RESUME));
        }
        recorder.progress.finish();
        Ok(results)
    }

    /// Returns the conditions that affect the figures, apart from specs and device.
    fn conditions(&self, effort: &Effort) -> BTreeMap<String, String> {
        [
            ("--frames", effort.frames.to_string()),
            ("errors", "over all points".into()),
            ("seen points", effort.seen_points.to_string()),
            ("--picture", effort.picture.map(|side| side.to_string()).join("x")),
            ("--truth", effort.truth.word().into()),
            ("--time", self.arguments.load.time.to_string()),
            (&format!("{SCENE}{}", self.scene.name), format!("{:08x}", self.fingerprint)),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .into()
    }
}

/// Stores each row as soon as it is measured, except rows from a lost device.
struct Recorder<'a> {
    progress: Progress,
    store: Option<Store>,
    context: &'a Context,
}

impl Observer for Recorder<'_> {
    fn row_begins(&mut self, scene: &str, spec: &Spec) {
        self.progress.begins(scene, spec);
    }

    fn row_ends(&mut self, row: &Row, spec: &Spec, results: &Results) -> Result<()> {
        self.progress.ends(row, spec);
        if self.context.is_lost() {
            return Err(lost(row));
        }
        self.store.as_ref().map_or(Ok(()), |store| store.write(results))
    }
}

/// Advice printed if the device is lost.
const RESUME: &str = "the device is lost: repeat the command with --resume, which keeps what is in --out";

fn lost(row: &Row) -> Error {
    Error::Gpu { operation: "measure", name: row.spec(), cause: row.reason.clone().into(), way_out: RESUME.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit on FLIP requires pictures, so the first look must draw them; without such a limit it must not.
    #[test]
    fn a_limit_of_flip_asks_for_pictures() {
        let truth = |limits: Limits| {
            Work { picture: [64, 36], software: false, lopsided: false, quick: false }.coarse(COARSE, &limits).truth
        };
        assert_eq!(truth(Limits { flip: Some(0.1), ..Limits::default() }), Extent::Choice);
        assert_eq!(truth(Limits::default()), Extent::Glance);
    }

    #[test]
    fn a_limit_is_above_zero() {
        assert_eq!(limit("--max-ms", Some("2"), 4.0).expect("a number"), Some(8.0));
        for wrong in ["0", "-1", "NaN", "inf", "", "two"] {
            assert!(limit("--max-ms", Some(wrong), 1.0).is_err(), "{wrong}");
        }
    }
}
