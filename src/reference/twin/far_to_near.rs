//! CPU twin of glsl/consume/far_to_near.comp: what a picture's casters are sorted by, in f32.

use super::gaussian::strand_axis;
use super::order::float_order;
use crate::scene::{Caster, View};
use glam::Vec3;

/// How far each caster's middle lies in front of the camera, as a number that falls as the distance rises.
pub fn far_to_near(camera: &View, casters: &[Caster]) -> Vec<u32> {
    let forward = Vec3::from(camera.forward);
    let middle = |c: &Caster| Vec3::from(c.position) - Vec3::from(camera.origin) + 0.5 * strand_axis(c);
    casters.iter().map(|caster| !float_order(middle(caster).dot(forward))).collect()
}
