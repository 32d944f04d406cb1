//! Builds, look-ups and pictures that ran, and how long they took.

use crate::Result;
use crate::bench::timing::passes::frame_ns;
use crate::bench::timing::stability::Stability;
use crate::gpu::{Calibration, PassTime};
use crate::technique::Built;
use std::time::Instant;

/// Consecutive builds of a row.
#[derive(Default)]
pub(in crate::bench) struct BuildSamples {
    /// How far their times may be trusted.
    pub(in crate::bench) steadiness: Stability,
    /// Each build, and both clocks after the last one.
    pub(in crate::bench) built: TimedBuilds,
    /// Per build, the passes before it that moved the world, where the world moves.
    pub(in crate::bench) moves: Vec<Vec<PassTime>>,
    /// Per build, the passes behind it that drew the world, where the world is simulated.
    pub(in crate::bench) draws: Vec<Vec<PassTime>>,
}

/// The timed builds and pictures of a row.
#[derive(Clone, Debug, Default)]
pub struct TimedBuilds {
    /// In the order in which they ran.
    pub builds: Vec<BuildTimes>,
    /// Relates the device's clock to the host's, read after the last build; none where it cannot be read.
    pub clock: Option<Calibration>,
    /// The look-ups that were timed, behind the builds, in their order.
    pub lookups: Vec<LookupTimes>,
    /// The clocks again, read after the last look-up.
    pub lookups_clock: Option<Calibration>,
    /// The pictures that were timed after the look-ups, in their order.
    pub draws: Vec<TimedRun>,
    /// The clocks again, read after the last picture.
    pub draws_clock: Option<Calibration>,
}

/// One timed build.
#[derive(Clone, Debug)]
pub struct BuildTimes {
    /// With each pass timed.
    pub each: TimedRun,
    /// The same build once more, with one timestamp pair around all passes, so that timestamps between passes cost
    /// nothing. None where the world moves, for a bake, and on a software device.
    pub whole: Option<TimedRun>,
}

/// Timed look-ups at many points at once.
#[derive(Clone, Debug)]
pub struct LookupTimes {
    /// The pass that asked.
    pub ran: TimedRun,
    /// How many points it asked about.
    pub points: usize,
}

/// A build, look-ups or a picture that ran.
#[derive(Clone, Debug)]
pub struct TimedRun {
    /// When the host began to record it.
    pub began: Instant,
    /// The host's time for it: recording, submitting, waiting, settling.
    pub host_ns: f64,
    /// Its passes, or all of them as one.
    pub passes: Vec<PassTime>,
}

impl TimedRun {
    pub(in crate::bench) fn of(build: impl FnOnce() -> Result<Built>) -> Result<Self> {
        let began = Instant::now();
        build().map(|Built { host_ns, passes, .. }| Self { began, host_ns, passes })
    }

    /// Runs passes that do not belong to a build.
    pub(in crate::bench) fn passes(run: impl FnOnce() -> Result<Vec<PassTime>>) -> Result<Self> {
        let began = Instant::now();
        run().map(|passes| Self { began, host_ns: began.elapsed().as_nanos() as f64, passes })
    }
}

impl LookupTimes {
    /// Nanoseconds per million points; none where the device has no timestamps.
    pub fn ns_per_million(&self) -> Option<f64> {
        frame_ns(&self.ran.passes).map(|ns| ns * 1e6 / self.points.max(1) as f64)
    }
}

impl BuildTimes {
    /// The run that the row's times are taken from.
    pub fn counted(&self) -> &TimedRun {
        self.whole.as_ref().unwrap_or(&self.each)
    }
}

impl BuildSamples {
    /// The host's time for each.
    pub(in crate::bench) fn host_ns(&self) -> Vec<f64> {
        self.built.builds.iter().map(|build| build.counted().host_ns).collect()
    }

    /// The passes of each, each timed.
    pub(in crate::bench) fn passes(&self) -> Vec<Vec<PassTime>> {
        self.built.builds.iter().map(|build| build.each.passes.clone()).collect()
    }
}

/// Timed pictures.
pub(in crate::bench) struct DrawTimes {
    /// Each, with every pass timed.
    pub frames: Vec<TimedRun>,
    /// The times that count, where the device has timestamps.
    pub counted_ns: Vec<f64>,
}
