//! A particle in motion, as stored by passes on the device.

use bytemuck::{Pod, Zeroable};

/// A particle with its velocity, in the device's layout; [`crate::shading::Points`] draws such particles. Twin: Body in
/// glsl/world/body.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Body {
    /// The particle's centre, then its radius.
    pub place: [f32; 4],
    /// Velocity along each axis, in world units per step; then the extinction.
    pub speed: [f32; 4],
}
