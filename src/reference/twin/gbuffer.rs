//! Twin of glsl/shading/gbuffer.comp: normal and depth of a pixel from its triangle.

use crate::scene::View;
use glam::{Vec2, Vec3};

/// A pixel's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Unit normal, pointing outwards on a closed surface.
    pub normal: Vec3,
    /// Depth along the camera's axis, in world units.
    pub z: f32,
}

/// Returns the surface at a pixel's centre. `side` is negative if the triangle's back is the outside of a closed surface.
pub fn gbuffer(camera: &View, corners: [Vec3; 3], side: i32, pixel: [u32; 2]) -> Seen {
    let [right, up, forward, origin] = [camera.right, camera.up, camera.forward, camera.origin].map(Vec3::from);
    let ndc = (Vec2::new(pixel[0] as f32, pixel[1] as f32) + 0.5)
        / Vec2::new(camera.width as f32, camera.height as f32)
        * 2.0
        - 1.0;
    let direction = forward + right * (ndc.x / camera.scale_x) + up * (ndc.y / camera.scale_y);
    let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let normal = if cross == Vec3::ZERO { cross } else { cross / cross.length() };
    let normal = if side < 0 { -normal } else { normal };
    let all_z = corners.map(|corner| (corner - origin).dot(forward));
    let [low, high] = [all_z.iter().copied().fold(f32::INFINITY, f32::min), all_z.iter().copied().fold(0.0, f32::max)];
    let z = (corners[0] - origin).dot(normal) / direction.dot(normal);
    // If the plane is seen edge-on, z may be NaN, which the comparison turns into `low`.
    Seen { normal, z: if z >= low { z.min(high) } else { low } }
}
