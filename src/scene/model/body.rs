//! A particle in motion, as passes on the device keep it.

use bytemuck::{Pod, Zeroable};

/// A particle with its velocity, in the device's layout: what [`crate::shading::Points`] draws. Twin: Body in glsl/world/body.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Body {
    /// The particle's middle, then its radius.
    pub place: [f32; 4],
    /// Velocity along each axis, world units per step; then the extinction.
    pub speed: [f32; 4],
}
