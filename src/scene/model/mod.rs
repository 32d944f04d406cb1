//! What casts, lights, camera, and in which order casters are drawn.

pub(super) mod backdrop;
pub(super) mod caster;
pub(super) mod field;
#[cfg(feature = "program")]
pub(super) mod fingerprint;
pub(super) mod fit;
pub(super) mod fog;
pub(super) mod fountain_law;
#[cfg(feature = "program")]
pub(crate) mod fountain_steps;
pub(crate) mod gaussian;
pub(super) mod light;
pub(super) mod order;
pub(super) mod paraboloid;
pub(super) mod picture;
#[cfg(feature = "program")]
pub(super) mod random;
pub(super) mod resolution;
pub(super) mod show;
pub(super) mod sides;
pub(super) mod smooth;
pub(super) mod time;
pub(super) mod view;
pub(super) mod volume;
#[cfg(feature = "program")]
pub(super) mod voxels;
