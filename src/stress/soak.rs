//! The result of a soak: `soak.json`.

use super::round::{Failure, Round};
use crate::measure::DeviceFacts;
use serde::{Deserialize, Serialize};

/// All rounds so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Soaked {
    /// [`super::SCHEMA`].
    pub schema: u32,
    /// The program's version.
    pub gobo: String,
    /// As it was given.
    pub command: String,
    /// Where it ran.
    pub device: DeviceFacts,
    /// Seed of the first round.
    pub seed: u64,
    /// How long it went on.
    pub seconds: f64,
    /// How many there were.
    pub rounds: u64,
    /// Techniques that were asked in them.
    pub asked: u64,
    /// Those of them that refused.
    pub refused: u64,
    /// All of them, in their order.
    pub failures: Vec<Failure>,
    /// Whether the host's memory was flat; absent where it was not to be told.
    pub is_flat: Option<bool>,
    /// Processes that rounds ran in: more than one where some hung or died.
    pub processes: u32,
    /// From one opening of the device to its closing, in their order.
    pub lives: Vec<Life>,
}

/// Some rounds on one open device.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Life {
    /// Seed of the first round.
    pub seed: u64,
    /// How many rounds.
    pub rounds: u64,
    /// Since the soak began, as it ended.
    pub seconds: f64,
    /// Which process, from 1.
    pub process: u32,
    /// The most that the process held after a round.
    pub most_host_bytes: Option<u64>,
    /// The memory that it held once the device was closed.
    pub host_bytes: Option<u64>,
    /// The device memory held after each round, the same for all rounds.
    pub device_bytes: u64,
}

impl Soaked {
    /// One more round.
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

/// How much the last quarter may be above the second: what a heap that is used at random holds apart, and a share.
const APART: u64 = 16 << 20;
const SHARE: f64 = 1.1;

/// Lives of one process that say something: a thousand rounds, in whose first half the largest have come.
const LEAST: usize = 40;

/// Whether what a process holds between devices has stopped growing: the median of the last quarter is no more than a tenth and
/// 16 MiB above that of the second. The first quarter is left out: a driver keeps what it makes once. None where there are too
/// few to say.
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

    /// What grows on and on, by 4 MiB from one opening to the next, is found out in 40 however it jumps about; what a driver makes
    /// once, and one high value, are no leak.
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
