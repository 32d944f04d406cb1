//! `gobo stress`

use crate::bench::stress::{
    self, CaseResult, Outcome, Results, SCHEMA, StressCase, StressPlan, Sweep, Worker, cases, serve,
};
use crate::cli::{DeviceArguments, say, say_json, test_reduction};
use crate::report::{Store, one_line, stress_csv, stress_device, stress_page, stress_table};
use crate::shading::runs;
use crate::technique::Spec;
use crate::technique::runs::List;
use crate::{Error, Result};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

#[derive(Args)]
pub struct Arguments {
    /// Cases, or scenes to change in each way [default: all cases]
    #[arg(value_name = "SCENE|CASE")]
    asked: Vec<String>,
    /// Technique spec, repeatable [default: every path of every technique, in small maps]
    #[arg(long = "technique", value_name = "SPEC")]
    techniques: Vec<String>,
    /// Folder for stress.json, stress.csv and stress.html, or soak.json and soak.html
    #[arg(long, default_value = "gobo-stress", value_name = "DIR")]
    out: PathBuf,
    /// Maximum seconds that a technique may take for one value, with its 8 orders and 3 steps, or for one round
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS", value_parser = seconds)]
    limit: f64,
    /// Soak: build random scenes with random techniques for this long, at least one round, and check answers and memory
    #[arg(long, value_name = "MINUTES", value_parser = minutes, conflicts_with_all = ["asked", "techniques"])]
    soak: Option<f64>,
    /// Seed of a soak's first round; each round takes the next number [default: 0]
    #[arg(long, value_name = "N", requires = "soak")]
    seed: Option<u32>,
    /// Print JSON instead of tables: the same figures, not rounded
    #[arg(long)]
    json: bool,
    /// Serve another process: stress starts itself this way
    #[arg(long, hide = true)]
    worker: bool,
    #[command(flatten)]
    device: DeviceArguments,
}

impl Arguments {
    /// With `GOBO_TEST_LITTLE`, returns a smaller version of the command.
    pub fn little(mut self) -> Self {
        if test_reduction::is_asked() {
            self.soak = self.soak.map(|_| 0.0);
        }
        self
    }
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|s| (0.001..=86400.0).contains(s)).ok_or_else(|| "give seconds, 0.001 to 86400".into())
}

fn minutes(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|m| (0.0..=1e5).contains(m)).ok_or_else(|| "give minutes, 0 to 100000".into())
}

/// Returns the list of cases for `--help`.
pub fn help() -> String {
    let line = |case: &StressCase| {
        crate::cli::help::fill(&format!("  {:<17} ", case.name), &format!("{} ({})", case.about, case.swept))
    };
    format!("Cases, and what is swept in each:\n{}", cases().map(line).collect::<String>())
}

/// Returns the plan of the named sweeps, or of all cases if none is named, with the named specs, or with every path of every technique in
/// the small sizes of a software device.
fn plan(arguments: &Arguments) -> Result<StressPlan> {
    let mut sweeps = Vec::new();
    for name in &arguments.asked {
        let (named, notes) = Sweep::named(name)?;
        crate::cli::tell(&notes);
        sweeps.extend(named);
    }
    if arguments.asked.is_empty() {
        sweeps.extend(cases().map(Sweep::of));
    }
    test_reduction::first(&mut sweeps, 1);
    if test_reduction::is_asked() {
        sweeps.iter_mut().for_each(|sweep| sweep.values = &sweep.values[..1]);
    }
    let mut named = Vec::new();
    for text in &arguments.techniques {
        named.extend(crate::cli::specs(text)?);
    }
    let specs = |list: List| -> Result<Vec<Spec>> {
        let mut specs = if named.is_empty() { runs(list, false)? } else { named.clone() };
        test_reduction::first(&mut specs, 2);
        Ok(specs)
    };
    let (smoke_specs, mesh_specs) = (specs(|runs| runs.stress_smoke)?, specs(|runs| runs.stress_meshes)?);
    Ok(StressPlan { sweeps, smoke_specs, mesh_specs })
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    if arguments.worker {
        return serve(|| arguments.device.open()).map(|()| ExitCode::SUCCESS);
    }
    // Input errors are found before a device is opened.
    let plan = plan(arguments)?;
    let store = Store::open(&arguments.out)?;
    let mut worker = Worker::start(own_command(arguments)?, Duration::from_secs_f64(arguments.limit))?;
    if let Some(minutes) = arguments.soak {
        return crate::cli::commands::soak::run(
            &mut worker,
            &store,
            minutes,
            arguments.seed.unwrap_or(0).into(),
            arguments.json,
        );
    }
    let mut results = Results {
        schema: SCHEMA,
        gobo: env!("CARGO_PKG_VERSION").into(),
        command: crate::cli::command_line(),
        device: worker.device.0.clone(),
        limit_s: arguments.limit,
        ..Results::default()
    };
    if !arguments.json {
        say(stress_device(&results))?;
    }
    stress::run(&mut worker, &plan, &mut results, print_row, |sweep, results| {
        write(&store, results)?;
        if arguments.json { Ok(()) } else { say(stress_table(results, &sweep.name)) }
    })?;
    store.write_text("stress.html", &stress_page(&results)?)?;
    match arguments.json {
        true => say_json(&results)?,
        false => say(arguments.out.join("stress.html").display())?,
    }
    let broken = results.verdicts.iter().any(|verdict| !verdict.invariants.is_empty());
    Ok(if broken { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Prints a line per row, as for a log.
fn print_row(row: &CaseResult, took: Duration) {
    let outcome = if row.outcome == Outcome::Answered { "answered" } else { &row.reason };
    let took_s = took.as_secs_f64();
    let CaseResult { case, value, technique, .. } = row;
    eprintln!("{}", one_line(&format!("{case} {value:e}: {technique}: {outcome}, {took_s:.2} s")));
}

/// Writes the results after every case, so that an interrupted run keeps them.
fn write(store: &Store, results: &Results) -> Result<()> {
    let fail = |cause: serde_json::Error| Error::output(&store.dir().join("stress.json"), cause);
    let json = serde_json::to_string_pretty(results).map_err(fail)? + "\n";
    store.write_text("stress.json", &json)?;
    store.write_text("stress.csv", &stress_csv(results)?)
}

/// Returns the command that starts this program as a worker. GOBO_RUNNER names a command that starts programs on another driver (setup.sh
/// writes it).
fn own_command(arguments: &Arguments) -> Result<Vec<OsString>> {
    let runner = std::env::var_os("GOBO_RUNNER").filter(|runner| !runner.is_empty());
    let fail = |cause: std::io::Error| Error::input("the program's own path", cause, "start it by its whole path");
    let mut command = match (runner, std::env::args_os().next()) {
        (Some(runner), Some(program)) => vec![runner, program],
        _ => vec![std::env::current_exe().map_err(fail)?.into_os_string()],
    };
    // The variables of tests apply to the worker too.
    command.extend(std::env::args_os().filter(|argument| argument == crate::cli::hooks::OPTION));
    command.extend(["stress", "--worker"].map(OsString::from));
    if let Some(device) = &arguments.device.device {
        command.extend(["--device".into(), device.into()]);
    }
    if arguments.device.validation {
        command.push("--validation".into());
    }
    Ok(command)
}
