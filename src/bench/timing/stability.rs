//! How far times can be trusted: their spread, the device's clock, and what else the machine did in the meantime.

use crate::bench::Timing;
use crate::gpu::Features;
use nvml_wrapper::Nvml;
use nvml_wrapper::enum_wrappers::device::Clock as Domain;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Ratio of the 95th to the 5th percentile above which a median means little.
const STEADY_SPREAD: f64 = 1.3;

/// Fraction of its highest clock below which a device is slow.
const STEADY_CLOCK: f64 = 0.9;

/// Fraction of the processors that other processes may use before it affects times.
const QUIET: f64 = 0.25;

/// Observations while builds were timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    /// Ratio of the 95th to the 5th percentile of a build's device time, or of its host time if there is no device time.
    pub spread: Option<f64>,
    /// The lowest and the highest device clock observed, in MHz. Absent if nothing reports it.
    pub clock_mhz: Option<[f64; 2]>,
    /// The highest clock that the device can reach, in MHz.
    pub highest_mhz: Option<f64>,
    /// Fraction of the processors used by other processes in the meantime, in [0, 1]. Absent if nothing reports it.
    pub busy: Option<f64>,
    /// Whether the row was measured a second time because the first time was not steady; the steadier one is kept.
    pub measured_again: bool,
}

impl Stability {
    /// Adds the spread of the times.
    pub(in crate::bench) fn with_spread(self, timing: Option<Timing>) -> Self {
        Self { spread: timing.filter(|t| t.samples > 1 && t.p05 > 0.0).map(|t| t.p95 / t.p05), ..self }
    }

    /// Returns the spread of the times if they are not steady.
    fn wide_spread(&self) -> Option<f64> {
        self.spread.filter(|spread| *spread > STEADY_SPREAD)
    }

    /// Returns the lowest clock observed and the highest that the device can reach, if it was slow.
    fn low_clock(&self) -> Option<[f64; 2]> {
        let seen = self.clock_mhz.zip(self.highest_mhz).map(|([low, _], most)| [low, most]);
        seen.filter(|[low, most]| *low < STEADY_CLOCK * most)
    }

    /// Returns the fraction of the processors that other processes used, if it affects times.
    fn busy_others(&self) -> Option<f64> {
        self.busy.filter(|busy| *busy > QUIET)
    }

    /// Returns short reasons not to trust the times; empty if they are steady.
    pub fn warnings(&self) -> Vec<String> {
        [
            self.wide_spread().map(|s| format!("p95/p05 {s:.1}")),
            self.low_clock().map(|[low, most]| format!("clock {low:.0} of {most:.0} MHz")),
            self.busy_others().map(|b| format!("others used {:.0} % of the processors", 100.0 * b)),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Returns the warnings for several rows: each reason once, at its worst, with the number of rows that have it.
    pub fn warnings_of(all: &[Self]) -> Vec<String> {
        let worst = |of: fn(&Self) -> Option<f64>| {
            let found: Vec<f64> = all.iter().filter_map(of).collect();
            let most = found.iter().copied().reduce(f64::max)?;
            Some((most, found.len()))
        };
        // The lowest clock is the worst.
        let clock = all.iter().filter_map(Self::low_clock).min_by(|a, b| a[0].total_cmp(&b[0]));
        let clocks = all.iter().filter_map(Self::low_clock).count();
        [
            worst(Self::wide_spread).map(|(s, rows)| format!("p95/p05 up to {s:.1} ({rows})")),
            clock.map(|[low, most]| format!("clock down to {low:.0} of {most:.0} MHz ({clocks})")),
            worst(Self::busy_others)
                .map(|(b, rows)| format!("others used up to {:.0} % of the processors ({rows})", 100.0 * b)),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Whether this run is steadier than `other`.
    pub(in crate::bench) fn is_steadier_than(&self, other: &Self) -> bool {
        let badness = |s: &Self| (s.warnings().len(), s.spread.unwrap_or(f64::INFINITY));
        badness(self) < badness(other)
    }
}

/// Watches the device's clock and the machine's load while something is timed.
pub(in crate::bench) struct Watch<'a> {
    meter: &'a ClockMeter,
    clock_mhz: Option<[f64; 2]>,
    began: Instant,
    others: Option<Jiffies>,
}

impl<'a> Watch<'a> {
    pub(in crate::bench) fn begin(meter: &'a ClockMeter) -> Self {
        Self { meter, clock_mhz: None, began: Instant::now(), others: Jiffies::now() }
    }

    /// Reads the clock. Call it while the device works or has just worked.
    pub(in crate::bench) fn look(&mut self) {
        let Some(now) = self.meter.now_mhz() else { return };
        self.clock_mhz = Some(self.clock_mhz.map_or([now; 2], |[low, high]| [low.min(now), high.max(now)]));
    }

    pub(in crate::bench) fn end(self, timing: Option<Timing>) -> Stability {
        // The counters have a resolution of a hundredth of a second, too coarse for shorter times.
        let counted = self.others.filter(|_| self.began.elapsed().as_secs_f64() > 0.25);
        let busy = counted.and_then(|before| Jiffies::now()?.others_since(before));
        let highest_mhz = self.meter.highest_mhz;
        let seen = Stability { clock_mhz: self.clock_mhz, highest_mhz, busy, ..Stability::default() };
        seen.with_spread(timing)
    }
}

/// Reads the clock of a device from its driver. No clock is read for software devices, or if no library reports one.
pub(in crate::bench) struct ClockMeter {
    nvml: Option<(Nvml, u32)>,
    highest_mhz: Option<f64>,
    /// Whether the clock once stayed low despite work. From then on nothing waits for it.
    stays_low: AtomicBool,
}

impl ClockMeter {
    /// Opens NVML for an NVIDIA device, if it is installed.
    pub(in crate::bench) fn of(features: &Features) -> Self {
        let open = || {
            let uuid = features.nvidia_uuid()?;
            let nvml = Nvml::init().ok()?;
            let index = (0..nvml.device_count().ok()?)
                .find(|i| nvml.device_by_index(*i).and_then(|d| d.uuid()).is_ok_and(|known| known == uuid))?;
            Some((nvml, index))
        };
        let nvml = open();
        let highest = nvml
            .as_ref()
            .and_then(|(nvml, i)| nvml.device_by_index(*i).ok()?.max_clock_info(Domain::Graphics).ok().map(f64::from));
        Self { nvml, highest_mhz: highest, stays_low: AtomicBool::new(false) }
    }

    /// Whether the device is known to be far below its highest clock and may still speed up.
    pub(in crate::bench) fn is_slow(&self) -> bool {
        let now = if self.stays_low.load(Ordering::Relaxed) { None } else { self.now_mhz() };
        now.zip(self.highest_mhz).is_some_and(|(now, highest)| now < STEADY_CLOCK * highest)
    }

    /// Records that the clock did not rise.
    pub(in crate::bench) fn give_up(&self) {
        self.stays_low.store(true, Ordering::Relaxed);
    }

    fn now_mhz(&self) -> Option<f64> {
        let (nvml, index) = self.nvml.as_ref()?;
        nvml.device_by_index(*index).ok()?.clock_info(Domain::Graphics).ok().map(f64::from)
    }
}

/// Processor time since the machine started, in hundredths of a second (proc(5)): of all processors, its idle part, and of this process.
#[derive(Clone, Copy)]
struct Jiffies {
    all: f64,
    idle: f64,
    own: f64,
}

impl Jiffies {
    fn now() -> Option<Self> {
        let [machine, process, status] =
            ["/proc/stat", "/proc/self/stat", "/proc/self/status"].map(std::fs::read_to_string);
        Self::of(&machine.ok()?, &process.ok()?, &status.ok()?)
    }

    /// Parses the texts of /proc/stat, /proc/self/stat and /proc/self/status. Only processors on which this process may run count, so that
    /// processes that divide a machine's processors between them, such as a scheduler's jobs, do not disturb each other.
    fn of(machine: &str, process: &str, status: &str) -> Option<Self> {
        let allowed = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"))?;
        let mut times = [0.0; 8];
        for line in machine.lines() {
            let mut fields = line.split_whitespace();
            let Some(Ok(cpu)) = fields.next().and_then(|name| name.strip_prefix("cpu")).map(str::parse) else {
                continue;
            };
            if is_listed(allowed, cpu) {
                // User, nice, system, idle, I/O wait, interrupts, soft interrupts, and time stolen by a hypervisor.
                let read = fields.map_while(|t| t.parse::<f64>().ok());
                times.iter_mut().zip(read).for_each(|(sum, time)| *sum += time);
            }
        }
        // The name, in brackets, may contain spaces; user and system time are the 14th and 15th fields.
        let fields: Vec<&str> = process.rsplit_once(')')?.1.split_whitespace().collect();
        let own = [11, 12].map(|i| fields.get(i).and_then(|t| t.parse::<f64>().ok()));
        let all = times.iter().sum();
        (all > 0.0).then_some(Self { all, idle: times[3] + times[4], own: own[0]? + own[1]? })
    }

    /// Returns the share of the processors' time since `before` that other processes used.
    fn others_since(self, before: Self) -> Option<f64> {
        let all = self.all - before.all;
        let others = (all - (self.idle - before.idle) - (self.own - before.own)).max(0.0);
        (all > 0.0).then(|| (others / all).min(1.0))
    }
}

/// Whether a list of processors in Linux's notation, such as `0-3,8`, contains this one.
fn is_listed(list: &str, cpu: u32) -> bool {
    list.trim().split(',').any(|part| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        matches!((first.parse::<u32>(), last.parse::<u32>()), (Ok(first), Ok(last)) if (first..=last).contains(&cpu))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_steady_is_said() {
        let steady = Stability { spread: Some(1.2), busy: Some(0.1), ..Stability::default() };
        assert_eq!(steady.warnings(), [] as [String; 0]);
        let clock = |low| Stability { clock_mhz: Some([low, 1980.0]), highest_mhz: Some(1980.0), ..steady };
        assert_eq!(
            (clock(1800.0).warnings().len(), clock(1260.0).warnings()),
            (0, vec!["clock 1260 of 1980 MHz".into()])
        );
        let wild = Stability { spread: Some(1.5), busy: Some(0.6), ..steady };
        assert_eq!(wild.warnings(), ["p95/p05 1.5", "others used 60 % of the processors"]);
        assert!(steady.is_steadier_than(&wild) && !wild.is_steadier_than(&steady));
        let timing = Timing { median: 2.0, p05: 1.0, p95: 3.0, samples: 9 };
        assert_eq!(Stability::default().with_spread(Some(timing)).spread, Some(3.0));
        assert_eq!(Stability::default().with_spread(Some(Timing { samples: 1, ..timing })).spread, None);
    }

    #[test]
    fn several_rows_are_said_at_their_worst() {
        let spread = |spread| Stability { spread: Some(spread), ..Stability::default() };
        let clock = |low| Stability { clock_mhz: Some([low, 1980.0]), highest_mhz: Some(1980.0), ..spread(1.2) };
        let busy = |busy, of: Stability| Stability { busy: Some(busy), ..of };
        let all =
            [spread(1.1), busy(0.6, spread(2.5)), busy(0.4, spread(4.25)), clock(1700.0), busy(0.3, clock(1260.0))];
        assert_eq!(
            Stability::warnings_of(&all),
            [
                "p95/p05 up to 4.2 (2)",
                "clock down to 1260 of 1980 MHz (2)",
                "others used up to 60 % of the processors (3)"
            ]
        );
        assert_eq!(Stability::warnings_of(&all[..1]), [] as [String; 0]);
    }

    /// This process may run on two of four processors, for ten seconds. Half of their time is idle, three seconds are this process, and the
    /// rest is another process. The other two processors are busy all the time, which must not matter.
    #[test]
    fn others_are_what_is_neither_idle_nor_own() {
        let of = |[busy, idle, elsewhere]: [u32; 3], own: &str| {
            let line = |cpu: u32, busy: u32, idle: u32| format!("cpu{cpu} {busy} 0 50 {idle} 10 0 0 0 0 0\n");
            let lines = [line(0, elsewhere, 0), line(1, busy, idle), line(2, 0, 0), line(3, busy, idle)].concat();
            let process = format!("7 (a b) c) S 1 1 1 0 -1 0 0 0 0 0 {own} 0 0");
            let status = "Name:\tgobo\nCpus_allowed:\ta\nCpus_allowed_list:\t1,3-3\n";
            Jiffies::of(&format!("cpu  9 9 9 9 9 0 0 0 0 0\n{lines}intr 5\n"), &process, status).expect("as in proc(5)")
        };
        let before = of([50, 500, 100], "30 10");
        let after = of([550, 1000, 1100], "250 90");
        let all = 2000.0;
        assert_eq!(after.others_since(before), Some((all - 1000.0 - 300.0) / all));
        assert_eq!(before.others_since(before), None);
        assert!(Jiffies::of("", "", "").is_none());
    }

    #[test]
    fn lists_of_processors_are_read() {
        let listed = |list: &str| (0..20).filter(|cpu| is_listed(list, *cpu)).collect::<Vec<_>>();
        assert_eq!(listed("\t0-3,8,10-11\n"), [0, 1, 2, 3, 8, 10, 11]);
        assert_eq!(listed("5"), [5]);
        assert!(listed("").is_empty() && listed("a-b").is_empty());
    }
}
