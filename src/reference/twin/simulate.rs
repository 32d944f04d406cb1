//! The fountain on the host is the twin of glsl/simulate/: one code, since a scene at a time says where its particles are.

pub use crate::scene::fountain_steps::{Rules, bodies, particles, pcg};
