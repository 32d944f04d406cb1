//! One file per subcommand.

pub(super) mod bake;
pub(super) mod compare;
pub(super) mod curve;
pub(super) mod devices;
pub(super) mod glsl;
pub(super) mod join;
pub(super) mod map;
pub(super) mod particles;
pub(super) mod recommend;
pub(super) mod render;
pub(super) mod report;
pub(super) mod shell;
pub(super) mod slice;
pub(super) mod soak;
pub(super) mod steps;
pub(super) mod stress;
pub(super) mod submit;
pub(super) mod view;
pub(super) mod voxels;
