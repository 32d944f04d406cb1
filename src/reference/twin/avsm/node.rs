//! CPU twin of glsl/maps/curve/node.glsl: the layout of a curve's nodes.

use crate::scene::FARTHEST;

/// Depth of an unused node. Twin: EMPTY.
pub const EMPTY: f32 = FARTHEST;

/// What nodes hold, and how that is interpolated. Twin: EXPONENTIAL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Transmittance, linearly. Source: Intel's sample of 2013, "Sampling from the AVSM data structure".
    Linear,
    /// Optical depth, linearly.
    Exponential,
}
