//! `gobo stress`

use super::DeviceArguments;
use crate::report::{Store, stress_csv, stress_page, stress_table};
use crate::stress::{Case, Outcome, Results, SCHEMA, Stressed, Worker, cases, serve, verdicts};
use crate::technique::{Spec, parse};
use crate::{Error, Result};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Who is asked when nobody is named: every path of every technique, in maps and grids that software devices build in no time.
const DEFAULT: [&str; 13] = [
    "avsm:size=32,path=two-pass|interlock|raster-order",
    "avsm:size=32,path=two-pass,resolve=whole",
    "avsm:size=32,path=binned,resolve=streaming|whole|cells",
    "avsm:size=32,path=two-pass,curve=linear",
    "psm:size=32,slices=64,path=raster|fused",
    "translucency-map:size=32,path=raster|binned",
    "beer-shadow-map:size=32,path=raster|binned",
    "uncompressed:size=32",
    "shadow-map:size=128",
    "voxelized:size=64",
    "voxel-grid:size=64,march=exact",
    "ism:size=32,points=1024,path=tiled|atomic|quads|triangles",
    "ray-query",
];

#[derive(Args)]
pub struct Arguments {
    /// Cases [default: all of them]
    #[arg(value_name = "CASE")]
    cases: Vec<String>,
    /// Technique spec, repeatable [default: every path of every technique, in small maps]
    #[arg(long = "technique", value_name = "SPEC")]
    techniques: Vec<String>,
    /// Folder for stress.json, stress.csv and stress.html
    #[arg(long, default_value = "gobo-stress", value_name = "DIR")]
    out: PathBuf,
    /// How long a technique may take for one value, 8 orders and 3 steps of it included, seconds
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS", value_parser = seconds)]
    limit: f64,
    /// Answer another process: what stress starts for itself
    #[arg(long, hide = true)]
    worker: bool,
    #[command(flatten)]
    device: DeviceArguments,
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|s| (0.001..=86400.0).contains(s)).ok_or_else(|| "give seconds, 0.001 to 86400".into())
}

/// The cases, for people.
pub fn help() -> String {
    let line = |case: &Case| format!("  {:<17} {} ({})\n", case.name, case.about, case.swept);
    format!("Cases, and what is swept in each:\n{}", cases().map(line).collect::<String>())
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    if arguments.worker {
        return serve(&arguments.device.open()?).map(|()| ExitCode::SUCCESS);
    }
    let asked: Vec<&Case> = match &arguments.cases[..] {
        [] => cases().collect(),
        names => names.iter().map(|name| Case::named(name)).collect::<Result<_>>()?,
    };
    let texts: Vec<&str> = match &arguments.techniques[..] {
        [] => DEFAULT.to_vec(),
        given => given.iter().map(String::as_str).collect(),
    };
    let mut specs = Vec::new();
    for text in texts {
        specs.extend(parse(text)?);
    }
    let store = Store::open(&arguments.out)?;
    let mut worker = Worker::start(own_command(arguments)?, Duration::from_secs_f64(arguments.limit))?;
    let (device, is_software) = worker.device.clone();
    let mut results = Results {
        schema: SCHEMA,
        gobo: env!("CARGO_PKG_VERSION").into(),
        command: super::command_line(),
        device,
        limit_s: arguments.limit,
        ..Results::default()
    };
    for case in asked {
        sweep(&mut worker, case, is_software, &specs, &mut results.rows)?;
        results.verdicts = verdicts(&results.rows);
        write(&store, &results)?;
    }
    println!("{}", stress_table(&results));
    store.write_text("stress.html", &stress_page(&results)?)?;
    println!("{}", arguments.out.join("stress.html").display());
    let broken = results.verdicts.iter().any(|verdict| !verdict.invariants.is_empty());
    Ok(if broken { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// All values of a case. Who has not answered in time is not asked about what is more extreme, nor who was refused.
fn sweep(worker: &mut Worker, case: &Case, is_software: bool, specs: &[Spec], rows: &mut Vec<Stressed>) -> Result<()> {
    let mut left = specs.to_vec();
    for value in case.values(is_software) {
        let from = rows.len();
        worker.ask(case, value, &left, |row| {
            let outcome = if row.outcome == Outcome::Answered { "answered" } else { &row.reason };
            eprintln!("{} {value:e}: {}: {outcome}", case.name, row.technique);
            rows.push(row);
        })?;
        let answered = |spec: &Spec| {
            rows[from..].iter().any(|row| row.technique == spec.short() && row.outcome != Outcome::NoAnswer && row.outcome != Outcome::Refused)
        };
        left.retain(answered);
    }
    Ok(())
}

/// After every case, so that an interrupted run keeps what it has.
fn write(store: &Store, results: &Results) -> Result<()> {
    let fail = |cause: serde_json::Error| Error::output(&store.dir().join("stress.json"), cause);
    let json = serde_json::to_string_pretty(results).map_err(fail)? + "\n";
    store.write_text("stress.json", &json)?;
    store.write_text("stress.csv", &stress_csv(results)?)
}

/// This program, to be started as a worker; GOBO_RUNNER starts programs on another driver (setup.sh writes it).
fn own_command(arguments: &Arguments) -> Result<Vec<OsString>> {
    let runner = std::env::var_os("GOBO_RUNNER").filter(|runner| !runner.is_empty());
    let fail = |cause: std::io::Error| Error::input("the program's own path", cause, "start it by its whole path");
    let mut command = match (runner, std::env::args_os().next()) {
        (Some(runner), Some(program)) => vec![runner, program],
        _ => vec![std::env::current_exe().map_err(fail)?.into_os_string()],
    };
    command.extend(["stress", "--worker"].map(OsString::from));
    if let Some(device) = &arguments.device.device {
        command.extend(["--device".into(), device.into()]);
    }
    if arguments.device.validation {
        command.push("--validation".into());
    }
    Ok(command)
}
