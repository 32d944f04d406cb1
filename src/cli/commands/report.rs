//! `gobo report`: results of several devices, drivers or editions side by side.

use crate::Result;
use crate::bench::{Comparison, Results, join};
use crate::cli::{say, say_json};
use crate::report::{Store, devices_answer, devices_csv, devices_json, devices_markdown, devices_page};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Results of gobo compare: results.json of each device; the others are compared with the first. Shards of a run (compare --shard)
    /// count as one run
    #[arg(value_name = "RESULTS.JSON", required = true)]
    results: Vec<PathBuf>,
    /// Folder for devices.html, devices.md and devices.csv
    #[arg(short, long, default_value = "gobo-report", value_name = "DIR")]
    out: PathBuf,
    /// Print JSON instead of the answer: the same figures as in devices.csv
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let read = |path: &PathBuf| Ok((path.display().to_string(), Results::read(path)?));
    let beside = Comparison::of(whole_runs(arguments.results.iter().map(read).collect::<Result<_>>()?)?)?;
    let store = Store::open(&arguments.out)?;
    store.write_text("devices.md", &devices_markdown(&beside))?;
    store.write_text("devices.csv", &devices_csv(&beside)?)?;
    store.write_text("devices.html", &devices_page(&beside)?)?;
    if arguments.json {
        say_json(&devices_json(&beside)?)?;
    } else {
        say(devices_answer(&beside))?;
        say(arguments.out.join("devices.html").display())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Joins the shards of each run into a single run, which takes the place of its first shard.
fn whole_runs(files: Vec<(String, Results)>) -> Result<Vec<(String, Results)>> {
    let of_run = |results: &Results| {
        let shard = results.shard.as_ref()?;
        Some((shard.list.clone(), shard.of, results.device.name.clone(), results.device.driver.clone()))
    };
    let mut runs: Vec<Vec<(String, Results)>> = Vec::new();
    for file in files {
        let run = of_run(&file.1);
        match runs.iter_mut().find(|files| run.is_some() && of_run(&files[0].1) == run) {
            Some(files) => files.push(file),
            None => runs.push(vec![file]),
        }
    }
    let whole = |files: Vec<(String, Results)>| match of_run(&files[0].1) {
        Some(_) => Ok((files[0].0.clone(), join(&files)?)),
        None => Ok(files.into_iter().next().unwrap_or_default()),
    };
    runs.into_iter().map(whole).collect()
}
