//! The camera as push constants, for pictures and for virtual lights that follow it.

use crate::gpu::push_struct;
use crate::scene::View;

push_struct! {
    /// Twin: CameraPush in glsl/shading/camera_push.glsl.
    pub(crate) struct CameraPush {
        origin: [f32; 3],
        scale_x: f32,
        right: [f32; 3],
        scale_y: f32,
        up: [f32; 3],
        near: f32,
        forward: [f32; 3],
        far: f32,
        size: [u32; 2],
    }
}

impl CameraPush {
    /// Converts a perspective view to push constants.
    pub(crate) fn of(camera: &View) -> Self {
        let View { origin, scale_x, right, scale_y, up, near, forward, far, width, height, .. } = *camera;
        Self { origin, scale_x, right, scale_y, up, near, forward, far, size: [width, height] }
    }
}
