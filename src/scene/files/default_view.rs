//! A light and a camera for files without them.

use crate::scene::files::contents::Contents;
use crate::scene::files::stage::{self, CameraEntry};
use crate::scene::{Camera, Light, LightKind};
use glam::DVec3;

/// Direction in which the light shines: right, forward, up.
const LIGHT: DVec3 = DVec3::new(0.47, 0.3, -0.83);

/// Direction in which the camera looks, in the same axes. It differs from the light's and points slightly downwards, so that shadows are
/// seen from the side.
const VIEW: DVec3 = DVec3::new(-0.45, 0.8, -0.32);

const FOV_Y_DEGREES: f64 = 38.0;

/// Aspect ratio (width / height) of the picture into which everything fits.
const ASPECT: f64 = 16.0 / 9.0;

/// Fraction of the picture's width and height that is filled.
const FILLED: f64 = 0.92;

/// Converts a vector from (right, forward, up) to world axes. Right is +x, unless that is up or down. Forward is thus +y if z is up; −z if
/// y is up, so that the camera sees the front of a glTF model, which faces +z; and +z if −y is up, as a capture's first camera looks.
fn oriented(vector: DVec3, up: DVec3) -> DVec3 {
    let right = if up.x == 0.0 { DVec3::X } else { DVec3::Y };
    (right * vector.x + up.cross(right) * vector.y + up * vector.z).normalize()
}

/// Returns a directional light that shines down at an angle.
pub(in crate::scene) fn light(up: DVec3) -> Light {
    Light { kind: LightKind::Directional { direction: oriented(LIGHT, up) }, radiance: [1.0; 3], radius: f64::INFINITY }
}

/// Returns a camera whose 16:9 picture contains everything, with a small margin. `up` is an axis.
pub(in crate::scene) fn camera(contents: &Contents, up: DVec3) -> std::result::Result<Camera, String> {
    let forward = oriented(VIEW, up);
    let right = forward.cross(up).normalize();
    let above = right.cross(forward);
    let in_view = |point: DVec3| DVec3::new(point.dot(right), point.dot(above), point.dot(forward));
    let boxes = contents.spheres().map(|(centre, radius)| (in_view(centre) - radius, in_view(centre) + radius));
    let bounds = boxes.reduce(|(low, high), (a, b)| (low.min(a), high.max(b)));
    let (low, high) = bounds.unwrap_or_default();
    if low == high {
        return Err("all of it is in one point".into());
    }
    let middle = (low + high) * 0.5;
    let tangent_y = (FOV_Y_DEGREES.to_radians() * 0.5).tan() * FILLED;
    let tangents = [(0, tangent_y * ASPECT), (1, tangent_y)];
    // Distance of the camera from the centre at which the picture's edges just touch a sphere.
    let needed = |(centre, radius): (DVec3, f64)| {
        let offset = in_view(centre) - middle;
        let touched = |(axis, tangent): (usize, f64)| {
            (offset[axis].abs() + radius * (1.0 + tangent * tangent).sqrt()) / tangent - offset.z
        };
        tangents.map(touched).into_iter().fold(f64::NEG_INFINITY, f64::max)
    };
    let distance = contents.spheres().map(needed).fold(0.0, f64::max);
    let target = right * middle.x + above * middle.y + forward * middle.z;
    stage::camera(&CameraEntry {
        position: (target - forward * distance).to_array(),
        target: target.to_array(),
        up: up.to_array(),
        fov_y_degrees: FOV_Y_DEGREES,
    })
}
