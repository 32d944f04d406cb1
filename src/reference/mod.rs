//! The truth in f64, and a CPU twin of each GPU pass that computes something. Never touches the GPU.

pub mod truth;
pub mod twin;
