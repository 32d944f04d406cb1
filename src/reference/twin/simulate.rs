//! The twin of glsl/animate/simulate/ is the host's own code for the fountain, which finds where a scene's particles are at a given time.

pub use crate::scene::fountain_steps::{Rules, bodies, particles, pcg};
