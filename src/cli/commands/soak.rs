//! `gobo stress --soak MINUTES`

use crate::bench::stress::{Failure, SCHEMA, Soaked, Worker, soak};
use crate::cli::{say, say_json};
use crate::report::{Store, one_line, soak_page};
use crate::{Error, Result};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// How often progress is printed, and the results so far are written.
const NEWS: Duration = Duration::from_secs(60);

/// Runs rounds for `minutes` minutes, but at least one, starting with the seed `seed`. Prints the result, as JSON with `json`.
pub fn run(worker: &mut Worker, store: &Store, minutes: f64, seed: u64, json: bool) -> Result<ExitCode> {
    let mut soaked = Soaked {
        schema: SCHEMA,
        gobo: env!("CARGO_PKG_VERSION").into(),
        command: crate::cli::command_line(),
        device: worker.device.0.clone(),
        seed,
        ..Soaked::default()
    };
    let mut told = Instant::now();
    soak(worker, &mut soaked, Duration::from_secs_f64(60.0 * minutes), |soaked, failures| {
        failures.iter().for_each(|failure| eprintln!("{}", line(failure)));
        if told.elapsed() < NEWS {
            return Ok(());
        }
        told = Instant::now();
        write(store, soaked)?;
        eprintln!("{}", sum(soaked));
        Ok(())
    })?;
    write(store, &soaked)?;
    store.write_text("soak.html", &soak_page(&soaked)?)?;
    match json {
        true => say_json(&soaked)?,
        false => say(format!("{}\n{}", sum(&soaked), store.dir().join("soak.html").display()))?,
    }
    Ok(if soaked.is_flat == Some(false) || !soaked.failures.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Writes the results every minute, so that an interrupted soak keeps them.
fn write(store: &Store, soaked: &Soaked) -> Result<()> {
    let fail = |cause: serde_json::Error| Error::output(&store.dir().join("soak.json"), cause);
    store.write_text("soak.json", &(serde_json::to_string_pretty(soaked).map_err(fail)? + "\n"))
}

fn line(failure: &Failure) -> String {
    one_line(&format!("seed {}: {}: {}", failure.seed, failure.technique, failure.broken))
}

fn sum(soaked: &Soaked) -> String {
    let Soaked { rounds, asked, refused, failures, processes, lives, .. } = soaked;
    let mib = |bytes: Option<u64>| bytes.map_or_else(|| "–".into(), |bytes| format!("{} MiB", bytes >> 20));
    let held = lives.iter().rev().find_map(|life| life.host_bytes);
    let flat = match soaked.is_flat {
        Some(true) => ", flat",
        Some(false) => ", growing",
        None => "",
    };
    format!(
        "{:.0} s: {rounds} rounds, {asked} techniques, {refused} refused, {} failures, {processes} processes, {} held{flat}",
        soaked.seconds,
        failures.len(),
        mib(held),
    )
}
