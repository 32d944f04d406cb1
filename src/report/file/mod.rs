//! Output files, written whole or not at all.

pub(super) mod atomic_write;
pub(super) mod store;
pub(super) mod trace;
