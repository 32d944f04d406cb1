//! How long things take, and how far those times can be trusted.

pub(super) mod copy_bandwidth;
pub(super) mod cost;
pub(super) mod host_memory;
pub(super) mod interlock;
pub(super) mod order_statistics;
pub(super) mod passes;
pub(super) mod raster_worth;
pub(super) mod repetition;
pub(super) mod stability;
pub(super) mod stage_rates;
pub(super) mod timed_runs;
pub(super) mod timer;
