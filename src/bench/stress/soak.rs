//! A soak: consecutive rounds of random scenes, and its result, `soak.json`.

use super::round::{Failure, Round};
use crate::Result;
use crate::bench::DeviceFacts;
use crate::bench::stress::Worker;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Number of rounds before the device is reopened. A device keeps every pipeline until it closes, and every round creates new ones.
const ROUNDS: u64 = 25;

/// All rounds so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Soaked {
    /// Schema version, [`super::SCHEMA`].
    pub schema: u32,
    /// The program's version.
    pub gobo: String,
    /// The command line as given.
    pub command: String,
    /// The device that the soak used.
    pub device: DeviceFacts,
    /// Seed of the first round.
    pub seed: u64,
    /// Duration of the soak, in seconds.
    pub seconds: f64,
    /// Number of rounds.
    pub rounds: u64,
    /// Number of techniques queried, over all rounds.
    pub asked: u64,
    /// Number of techniques that refused.
    pub refused: u64,
    /// All failures, in order.
    pub failures: Vec<Failure>,
    /// Whether the host's memory has stopped growing ([`is_flat`]); absent if there are too few rounds to tell.
    pub is_flat: Option<bool>,
    /// Number of processes in which rounds ran: more than one if some hung or died.
    pub processes: u32,
    /// The periods from each opening of the device to its closing, in order.
    pub lives: Vec<Life>,
}

/// The rounds between one opening of the device and its closing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Life {
    /// Seed of the first round.
    pub seed: u64,
    /// Number of rounds.
    pub rounds: u64,
    /// Seconds from the beginning of the soak to the end of this period.
    pub seconds: f64,
    /// Number of the process, from 1.
    pub process: u32,
    /// Largest memory of the process after a round, in bytes.
    pub most_host_bytes: Option<u64>,
    /// The process's memory after the device was closed, in bytes.
    pub host_bytes: Option<u64>,
    /// Largest device memory after a round, in bytes.
    pub device_bytes: u64,
}

impl Soaked {
    /// Adds a round.
    pub fn add(&mut self, round: Round) {
        self.rounds += 1;
        self.asked += round.asked;
        self.refused += round.refused;
        if let Some(life) = self.lives.last_mut() {
            life.rounds += 1;
            life.most_host_bytes = life.most_host_bytes.max(round.host_bytes);
            life.device_bytes = life.device_bytes.max(round.device_bytes);
        }
        self.failures.extend(round.failures);
    }
}

/// Runs rounds for the given duration, but at least one. The first has the seed `soaked.seed`, which rises by 1 from round to round.
/// `round_ends` is called with the soak so far and the failures of the last round.
///
/// # Errors
/// Fails if [`Worker::round`] or `round_ends` does.
pub fn soak(
    worker: &mut Worker,
    soaked: &mut Soaked,
    duration: Duration,
    mut round_ends: impl FnMut(&Soaked, &[Failure]) -> Result<()>,
) -> Result<()> {
    let (start, mut is_closed) = (Instant::now(), true);
    let is_over = || start.elapsed() >= duration;
    for seed in soaked.seed.. {
        let process = worker.processes;
        if is_closed {
            soaked.lives.push(Life { seed, process, ..Life::default() });
        }
        let failed = soaked.failures.len();
        soaked.add(worker.round(seed)?);
        // A lost device must not make the next round fail, so the device is reopened.
        let has_failed = soaked.failures.len() > failed;
        let is_full = soaked.lives.last().is_some_and(|life| life.rounds == ROUNDS);
        is_closed = worker.processes != process || has_failed || is_full || is_over();
        soaked.seconds = start.elapsed().as_secs_f64();
        if is_closed && worker.processes == process {
            close(worker, soaked, seed)?;
        }
        soaked.processes = worker.processes;
        round_ends(soaked, &soaked.failures[failed..])?;
        if is_over() {
            break;
        }
    }
    soaked.is_flat = is_flat(&soaked.lives);
    Ok(())
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

/// Limit for the memory of the last quarter, relative to the second: a factor of `SHARE`, plus `APART` bytes for heap fragmentation.
const APART: u64 = 16 << 20;
const SHARE: f64 = 1.1;

/// Minimum number of lives of a process before memory is judged. That is about a thousand rounds, so the largest rounds fall into the first
/// half.
const LEAST: usize = 40;

/// Whether memory has stopped growing. This concerns the memory that the last process holds between two devices, measured once per life:
/// the median over the last quarter of lives may exceed the median over the second quarter by at most a tenth and 16 MiB. The first quarter
/// is left out, since a driver allocates some memory once and keeps it. `None` if there are too few lives.
pub fn is_flat(lives: &[Life]) -> Option<bool> {
    let process = lives.last()?.process;
    let of_it = lives.iter().filter(|life| life.process == process);
    let held: Vec<u64> = of_it.filter_map(|life| life.host_bytes).collect();
    if held.len() < LEAST {
        return None;
    }
    let quarter = |from: usize| median(&held[from * held.len() / 4..(from + 1) * held.len() / 4]);
    Some(quarter(3) as f64 <= SHARE * quarter(1) as f64 + APART as f64)
}

fn median(values: &[u64]) -> u64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIB: u64 = 1 << 20;

    fn lives(held: impl Fn(u64) -> u64, count: u64, process: u32) -> Vec<Life> {
        let life = |i| Life { host_bytes: Some(held(i) * MIB), process, ..Life::default() };
        (0..count).map(life).collect()
    }

    /// Steady growth of 4 MiB per opening must be detected within 40 openings, despite fluctuation. A single early step, as caused by
    /// drivers, and a single high value must not count as leaks.
    #[test]
    fn what_grows_is_not_flat() {
        assert_eq!(is_flat(&lives(|i| 300 + 10 * (i % 3), 40, 1)), Some(true));
        assert_eq!(is_flat(&lives(|i| 300 + 4 * i + 10 * (i % 3), 40, 1)), Some(false));
        assert_eq!(is_flat(&lives(|i| if i < 8 { 100 } else { 400 }, 40, 1)), Some(true));
        assert_eq!(is_flat(&lives(|i| if i == 39 { 4000 } else { 400 }, 40, 1)), Some(true));
        assert_eq!(is_flat(&lives(|_| 300, 39, 1)), None);
        // Each process has a memory of its own.
        assert_eq!(is_flat(&[lives(|_| 100, 40, 1), lives(|_| 300, 40, 2)].concat()), Some(true));
        let unknown = vec![Life::default(); 40];
        assert_eq!(is_flat(&unknown), None);
    }
}
