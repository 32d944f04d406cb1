//! Profiling: timestamps, pipeline statistics, clocks, compiled programs, tools.

pub(super) mod calibration;
pub(super) mod counts;
pub(super) mod executables;
pub(super) mod times;
pub(super) mod tools;
