//! Profiling: timestamps, pipeline statistics, clocks, compiled programs, tools.

pub(super) mod calibration;
pub(super) mod counts;
pub(super) mod executables;
pub(super) mod times;
pub(super) mod tools;

/// Maximum number of passes timed per submission, with two timestamps each.
pub(in crate::gpu) const MAX_PASSES: u32 = 512;
