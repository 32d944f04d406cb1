//! Output files, written completely or not at all.

pub(super) mod atomic_write;
pub(super) mod store;
pub(super) mod trace;
