//! The truth in f64, and a CPU twin of each GPU pass that computes something. Nothing here touches the GPU.

pub mod truth;
pub mod twin;
