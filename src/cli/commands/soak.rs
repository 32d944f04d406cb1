//! `gobo stress --soak MINUTES`

use crate::bench::stress::{Failure, Life, SCHEMA, Soaked, Worker, is_flat};
use crate::cli::{say, say_json};
use crate::report::{Store, one_line, soak_page};
use crate::{Error, Result};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Rounds until the device is opened again. A device keeps each pipeline until it closes, and every round makes new
/// ones.
const ROUNDS: u64 = 25;

/// How often progress is printed, and the results so far are written.
const NEWS: Duration = Duration::from_secs(60);

/// Runs rounds for `minutes` minutes, but at least one round. The first round has the seed `seed`, and the seed rises
/// by 1 from round to round. Prints the result, as JSON with `json`.
pub fn run(worker: &mut Worker, store: &Store, minutes: f64, seed: u64, json: bool) -> Result<ExitCode> {
    let mut soaked = Soaked {
        schema: SCHEMA,
        gobo: env!("CARGO_PKG_VERSION").into(),
        command: crate::cli::command_line(),
        device: worker.device.0.clone(),
        seed,
        ..Soaked::default()
    };
    let (start, mut told, mut is_closed) = (Instant::now(), Instant::now(), true);
    let is_over = || start.elapsed().as_secs_f64() >= 60.0 * minutes;
    for next in seed.. {
        let process = worker.processes;
        if is_closed {
            soaked.lives.push(Life { seed: next, process, ..Life::default() });
        }
        let failed = soaked.failures.len();
        soaked.add(worker.round(next)?);
        // A lost device must not make the next round fail, so it is opened again.
        let has_failed = soaked.failures.len() > failed;
        let is_full = soaked.lives.last().is_some_and(|life| life.rounds == ROUNDS);
        is_closed = worker.processes != process || has_failed || is_full || is_over();
        soaked.seconds = start.elapsed().as_secs_f64();
        if is_closed && worker.processes == process {
            close(worker, &mut soaked, next)?;
        }
        soaked.processes = worker.processes;
        soaked.failures[failed..].iter().for_each(|failure| eprintln!("{}", line(failure)));
        if told.elapsed() >= NEWS {
            told = Instant::now();
            write(store, &soaked)?;
            eprintln!("{}", sum(&soaked));
        }
        if is_over() {
            break;
        }
    }
    soaked.is_flat = is_flat(&soaked.lives);
    write(store, &soaked)?;
    store.write_text("soak.html", &soak_page(&soaked)?)?;
    match json {
        true => say_json(&soaked)?,
        false => say(format!("{}\n{}", sum(&soaked), store.dir().join("soak.html").display()))?,
    }
    Ok(if soaked.is_flat == Some(false) || !soaked.failures.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Closes the device after the round with that seed. Leaks or messages on closing count as a failure of that round.
fn close(worker: &mut Worker, soaked: &mut Soaked, seed: u64) -> Result<()> {
    let (host_bytes, said) = worker.reopen()?;
    let failure = |said| Failure { seed, broken: format!("as the device closed: {said}"), ..Failure::default() };
    soaked.failures.extend(said.into_iter().map(failure));
    if let Some(life) = soaked.lives.last_mut() {
        (life.host_bytes, life.seconds) = (host_bytes, soaked.seconds);
    }
    Ok(())
}

/// Written every minute, so that an interrupted soak keeps its results.
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
