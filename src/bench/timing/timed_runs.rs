//! Builds, look-ups and pictures that ran, with their times.

use crate::Result;
use crate::bench::timing::passes::frame_ns;
use crate::bench::timing::stability::Stability;
use crate::gpu::{Calibration, PassTime};
use crate::technique::Built;
use std::time::Instant;

/// Consecutive builds of a row.
#[derive(Default)]
pub(in crate::bench) struct BuildSamples {
    /// How far their times can be trusted.
    pub(in crate::bench) steadiness: Stability,
    /// All builds, and the device's and the host's clock read after the last one.
    pub(in crate::bench) built: TimedBuilds,
    /// Passes before each build that moved the world, if the world moves.
    pub(in crate::bench) moves: Vec<Vec<PassTime>>,
    /// Passes after each build that drew the world, if the world is simulated.
    pub(in crate::bench) draws: Vec<Vec<PassTime>>,
}

/// The timed builds and pictures of a row.
#[derive(Clone, Debug, Default)]
pub struct TimedBuilds {
    /// The builds, in the order in which they ran.
    pub builds: Vec<BuildTimes>,
    /// Relates the device's clock to the host's, read after the last build; `None` if it cannot be read.
    pub clock: Option<Calibration>,
    /// The look-ups timed after the builds, in order.
    pub lookups: Vec<LookupTimes>,
    /// The device's and the host's clock, read again after the last look-up.
    pub lookups_clock: Option<Calibration>,
    /// The pictures timed after the look-ups, in order.
    pub draws: Vec<TimedRun>,
    /// The device's and the host's clock, read again after the last picture.
    pub draws_clock: Option<Calibration>,
}

/// One timed build.
#[derive(Clone, Debug)]
pub struct BuildTimes {
    /// The build with each pass timed.
    pub each: TimedRun,
    /// The same build repeated with a single timestamp pair around all passes, so that timestamps between passes cost
    /// nothing. `None` if the world moves, for a bake, and on a software device.
    pub whole: Option<TimedRun>,
}

/// Timed look-ups, at many points at once.
#[derive(Clone, Debug)]
pub struct LookupTimes {
    /// The pass that ran the look-ups.
    pub ran: TimedRun,
    /// Number of points looked up.
    pub points: usize,
}

/// A build, a batch of look-ups or a picture that ran.
#[derive(Clone, Debug)]
pub struct TimedRun {
    /// When the host began recording it.
    pub began: Instant,
    /// Host time for it, in nanoseconds: recording, submitting, waiting, settling.
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
    /// Returns nanoseconds per million points; `None` if the device has no timestamps.
    pub fn ns_per_million(&self) -> Option<f64> {
        frame_ns(&self.ran.passes).map(|ns| ns * 1e6 / self.points.max(1) as f64)
    }
}

impl BuildTimes {
    /// Returns the run that provides the row's times.
    pub fn counted(&self) -> &TimedRun {
        self.whole.as_ref().unwrap_or(&self.each)
    }
}

impl BuildSamples {
    /// Returns the host time of each build.
    pub(in crate::bench) fn host_ns(&self) -> Vec<f64> {
        self.built.builds.iter().map(|build| build.counted().host_ns).collect()
    }

    /// Returns the passes of each build, individually timed.
    pub(in crate::bench) fn passes(&self) -> Vec<Vec<PassTime>> {
        self.built.builds.iter().map(|build| build.each.passes.clone()).collect()
    }
}

/// Timed pictures.
pub(in crate::bench) struct DrawTimes {
    /// The pictures, with every pass timed.
    pub frames: Vec<TimedRun>,
    /// The times that count; empty if the device has no timestamps.
    pub counted_ns: Vec<f64>,
}
