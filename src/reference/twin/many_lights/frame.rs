//! Twin of glsl/shading/many_lights/frame.glsl: positions and surfaces in this frame's picture and in the previous one.

use crate::scene::View;
use std::array::from_fn;

/// A camera, and the directions of its pixels' rays. Twin: Frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The camera.
    pub camera: View,
    /// Ray direction at the upper left corner of the picture, with length 1 along z.
    pub corner: [f32; 3],
    /// Change of that direction per pixel to the right.
    pub across: [f32; 3],
    /// Change of that direction per pixel down.
    pub down: [f32; 3],
    /// How far a point may lie off a surface and still belong to it, in world units per unit of z.
    pub edge: f32,
}

impl Frame {
    /// Twin: frame_direction.
    pub fn direction(&self, [x, y]: [u32; 2]) -> [f32; 3] {
        from_fn(|i| self.corner[i] + (x as f32 + 0.5) * self.across[i] + (y as f32 + 0.5) * self.down[i])
    }
}
