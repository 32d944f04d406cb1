//! Resources on a device: buffers, images, sets, pipelines, acceleration structures.

pub(super) mod acceleration;
pub(super) mod bindings;
pub(super) mod buffer;
pub(super) mod constants;
pub(super) mod image;
pub(super) mod kernel;
pub(super) mod mapped;
pub(super) mod pipelines;
pub(super) mod push;
pub(super) mod read_back;
pub(super) mod spirv;

use std::any::Any;
use std::sync::Arc;

/// A resource used by a recorded command, kept alive until the device is done.
pub(in crate::gpu) type KeepAlive = Arc<dyn Any + Send + Sync>;
