//! Devices: their capabilities, how one is opened, and the context that owns it.

pub(super) mod context;
pub(super) mod device_owner;
pub(super) mod enabled;
pub(super) mod features;
pub(crate) mod instance;
pub(super) mod limits;
