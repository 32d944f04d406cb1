//! `gobo report`: results of several devices, drivers or editions side by side.

use super::say;
use crate::Result;
use crate::measure::{Beside, Results};
use crate::report::{Store, devices_answer, devices_csv, devices_markdown, devices_page};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// What gobo compare has measured: results.json of each device, the first one to hold the others against
    #[arg(value_name = "RESULTS.JSON", required = true)]
    results: Vec<PathBuf>,
    /// Folder for devices.html, devices.md and devices.csv
    #[arg(short, long, default_value = "gobo-report", value_name = "DIR")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let read = |path: &PathBuf| Ok((path.display().to_string(), Results::read(path)?));
    let beside = Beside::of(arguments.results.iter().map(read).collect::<Result<_>>()?)?;
    let store = Store::open(&arguments.out)?;
    store.write_text("devices.md", &devices_markdown(&beside))?;
    store.write_text("devices.csv", &devices_csv(&beside)?)?;
    store.write_text("devices.html", &devices_page(&beside)?)?;
    say(devices_answer(&beside))?;
    say(arguments.out.join("devices.html").display())?;
    Ok(ExitCode::SUCCESS)
}
