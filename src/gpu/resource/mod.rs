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
