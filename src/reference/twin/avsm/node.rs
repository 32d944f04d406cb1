//! CPU twin of glsl/maps/curve/node.glsl: the layout of a curve's nodes.

use crate::scene::FARTHEST;

/// Depth of an unused node. Twin: EMPTY.
pub const EMPTY: f32 = FARTHEST;

/// Quantity that nodes hold, and its interpolation. Twin: EXPONENTIAL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Transmittance, interpolated linearly. Source: Intel's sample of 2013, "Sampling from the AVSM data structure".
    Linear,
    /// Optical depth, interpolated linearly.
    Exponential,
}
