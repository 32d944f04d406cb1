//! The twin of glsl/simulate/ is the fountain on the host itself, which finds where a scene's particles are at a time.

pub use crate::scene::fountain_steps::{Rules, bodies, particles, pcg};
