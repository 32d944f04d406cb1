//! `gobo submit`: the standard run as one file, and checks of such files.

use crate::bench::{
    self, DeviceFacts, Effort, Plan, PlannedScene, Results, SUBMISSION, Submission, answers_hash, noise, stage_rates,
    standard,
};
use crate::cli::output::progress::Progress;
use crate::cli::{DeviceArguments, MESSAGES, complain, say, say_json, test_reduction};
use crate::gpu::Context;
use crate::report::{submission_table, write_whole};
use crate::scene::Scene;
use crate::{Error, Result};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Environment variables that make the loader load layers which no program requested.
const LAYERS: [&str; 2] = ["VK_INSTANCE_LAYERS", "VK_LOADER_LAYERS_ENABLE"];

/// In tests, the maximum number of rows per scene to measure again, and the scenes: there is no time for all.
const FEW: (usize, &[&str]) = (2, &["plume_8k", "cornell"]);

#[derive(Args)]
pub struct Arguments {
    /// The file to write
    #[arg(short, long, default_value = "gobo-submission.json", value_name = "FILE")]
    out: PathBuf,
    /// Measure the errors in such files again on this device, and report which files should not count, and why
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "out")]
    check: Vec<PathBuf>,
    /// Print the file's JSON instead of the table
    #[arg(long, conflicts_with = "check")]
    json: bool,
    #[command(flatten)]
    device: DeviceArguments,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    if !arguments.check.is_empty() {
        return check(arguments);
    }
    is_writable(&arguments.out)?;
    let context = arguments.device.open()?;
    let submission = measured(arguments, &context)?;
    let json = serde_json::to_string(&submission).map_err(|cause| Error::output(&arguments.out, cause))?;
    write_whole(&arguments.out, (json + "\n").as_bytes())?;
    match arguments.json {
        true => say_json(&submission)?,
        false => say(submission_table(&submission))?,
    }
    let marks = submission.marks()?;
    marks.iter().for_each(|mark| complain(format!("gobo: it will be listed and not counted: {mark}")));
    if !arguments.json {
        say(format!(
            "{}: to share it, add the file to results/community/ of Gobo's repository in a pull request, with this table as its text. \
             Nothing was sent.",
            arguments.out.display()
        ))?;
    }
    Ok(if submission.failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Checks that the file can be written, before measuring for minutes.
fn is_writable(out: &Path) -> Result<()> {
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        return Err(Error::output(out, "its folder is not there"));
    }
    if out.is_dir() { Err(Error::output(out, "it is a folder")) } else { Ok(()) }
}

fn measured(arguments: &Arguments, context: &Context) -> Result<Submission> {
    let start = Instant::now();
    let scenes = standard::scenes()?;
    let conditions = standard::conditions(&scenes);
    let mut scenes: Vec<Scene> = scenes.into_iter().map(|animated| animated.scene).collect();
    test_reduction::first(&mut scenes, 1);
    let planned = |scene| {
        let specs = test_reduction::specs(standard::specs(scene)?);
        Ok(PlannedScene { frames: std::slice::from_ref(scene).into(), specs })
    };
    let little = Effort { frames: 2, warm_up: 0, lookups: test_reduction::LOOKUPS, ..standard::EFFORT };
    let effort = if test_reduction::is_asked() { little } else { standard::EFFORT };
    let mut plan = Plan::new(effort, scenes.iter().map(planned).collect::<Result<_>>()?);
    let device = DeviceFacts { stages: stage_rates(context)?, ..DeviceFacts::of(context.features()) };
    // The submission itself records the commit, and the file's path does not matter.
    let mut results = Results { commit: None, changed: None, ..Results::new("gobo submit".into(), conditions, device) };
    let mut progress = Progress::new(plan.left());
    bench::run(context, &mut plan, &mut results, &mut progress)?;
    if context.is_lost() {
        return Err(plan.lost(context));
    }
    progress.finish();
    let named = LAYERS.iter().filter_map(|name| std::env::var(name).ok());
    Ok(Submission {
        submission: SUBMISSION,
        commit: env!("GOBO_COMMIT").into(),
        changed: env!("GOBO_CHANGED") != "false",
        seconds: start.elapsed().as_secs_f64(),
        layers: context.tools().to_vec(),
        environment: named
            .flat_map(|list| list.split([':', ',', ';']).map(str::to_owned).collect::<Vec<_>>())
            .collect(),
        validation: arguments.device.validation,
        failed: MESSAGES.all().iter().map(|message| message.replace('\n', " ")).collect(),
        noise: noise(&results.rows),
        answers: results.rows.iter().map(answers_hash).collect(),
        results,
    })
}

/// Reports for each file whether it counts. Fails if one does not.
fn check(arguments: &Arguments) -> Result<ExitCode> {
    let files: Vec<(&Path, Submission)> =
        arguments.check.iter().map(|path| Ok((path.as_path(), Submission::read(path)?))).collect::<Result<_>>()?;
    let context = arguments.device.open()?;
    let all: Vec<&Submission> = files.iter().map(|(_, submission)| submission).collect();
    let found = standard::again(&context, &all, test_reduction::is_asked().then_some(FEW))?;
    let mut all_count = true;
    for ((path, submission), again) in files.iter().zip(found) {
        let marks = [submission.marks()?, again.against].concat();
        all_count &= marks.is_empty();
        let device = &submission.results.device.name;
        say(format!("{}: {device}: {} rows agree with this device", path.display(), again.agree))?;
        match marks.is_empty() {
            true => say("  it counts")?,
            false => marks.iter().try_for_each(|mark| say(format!("  marked: {mark}")))?,
        }
    }
    Ok(if all_count { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
