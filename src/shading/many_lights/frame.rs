//! A frame's camera, in the form needed by passes that decide whether two pixels see the same surface.

use crate::scene::View;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// How far a point may be off a surface and still belong to it, as a multiple of a pixel's size at that distance. A step of two pixels is
/// hardly visible.
const EDGE_PIXELS: f64 = 2.0;

/// A camera, and the directions of its pixels' rays. Twin: Frame in glsl/shading/many_lights/frame.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameData {
    /// The camera.
    pub camera: View,
    /// Direction at the upper left corner of the picture, with length 1 along z.
    pub corner: [f32; 3],
    /// Change of that direction per pixel to the right.
    pub across: [f32; 3],
    /// Change of that direction per pixel down.
    pub down: [f32; 3],
    /// How far a point may be off a surface and still belong to it, in world units per unit of z.
    pub edge: f32,
}

impl FrameData {
    /// Returns the frame of a perspective camera.
    pub fn of(camera: &View) -> Self {
        let direction = |x: f64, y: f64| camera.ray(DVec2::new(x, y)).direction;
        let corner = direction(0.0, 0.0);
        let [across, down] = [direction(1.0, 0.0), direction(0.0, 1.0)].map(|other| other - corner);
        let single = |v: DVec3| v.as_vec3().to_array();
        let edge = (EDGE_PIXELS * down.length()) as f32;
        Self { camera: *camera, corner: single(corner), across: single(across), down: single(down), edge }
    }
}
