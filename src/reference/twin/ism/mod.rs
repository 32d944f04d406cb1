//! Twins of glsl/technique/ism/: imperfect shadow maps.

pub mod adapt;
pub mod clusters;
pub mod fill;
pub mod look_up;
pub mod map;
pub mod points;
pub mod splat;
