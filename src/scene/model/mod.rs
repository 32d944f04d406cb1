//! What casts, lights, camera, and in which order casters are drawn.

pub(super) mod caster;
#[cfg(feature = "program")]
pub(super) mod change;
#[cfg(feature = "program")]
pub(super) mod fingerprint;
pub(super) mod fit;
pub(super) mod fog;
pub(super) mod fountain_law;
pub(crate) mod gaussian;
pub(super) mod light;
pub(super) mod order;
pub(super) mod paraboloid;
pub(super) mod picture;
#[cfg(feature = "program")]
pub(super) mod random;
pub(super) mod resolution;
pub(super) mod sides;
pub(super) mod time;
pub(super) mod view;
