//! CPU twin of the receivers of glsl/maps/opaque.glsl, in f32: where a surface point is looked up in a depth map, and which texels around
//! it block its light.

use crate::scene::{Projection, View};
use glam::{Vec2, Vec3};

/// Returns the steps to the next texel right and up, in world units; in perspective, at z = 1.
fn texel(view: &View) -> [Vec3; 2] {
    let side = |axis: [f32; 3], scale: f32, count: u32| Vec3::from(axis) * (2.0 / (count as f32 * scale));
    [side(view.right, view.scale_x, view.width), side(view.up, view.scale_y, view.height)]
}

/// Returns the position at which a surface point is looked up. Twin: opaque_receiver.
pub fn moved(view: &View, position: Vec3, normal: Vec3, normal_bias: f32) -> Vec3 {
    let offset = position - Vec3::from(view.origin);
    let z = if view.projection() == Projection::Parallel { 1.0 } else { offset.dot(view.forward.into()) };
    let [right, up] = texel(view);
    let texels = normal.dot(right).abs() + normal.dot(up).abs();
    let rounding = 2.4e-7 * position.abs().element_sum() + 1.2e-6 * offset.length();
    let by = normal_bias * texels * z;
    let by = if view.projection() == Projection::Parallel { by } else { by.min(-0.5 * offset.dot(normal)) };
    position + normal * by.max(rounding)
}

/// The receiver with which texels around a point are compared. Twin: Receiver.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    view: View,
    z: f32,
    /// Depth of the point, clamped to 1, the depth stored where there is no mesh.
    pub depth: f32,
    along: f32,
    across: Vec2,
    /// Height above the surface's plane beyond which a texel shadows the point, in world units.
    pub least: f32,
}

impl Receiver {
    /// Creates the receiver at `position`, which has already been moved off its surface; `normal` is 0 for points in space.
    /// Twin: opaque_compared.
    pub fn new(view: &View, position: Vec3, normal: Vec3) -> Self {
        let offset = position - Vec3::from(view.origin);
        let forward = Vec3::from(view.forward);
        let z = offset.dot(forward);
        let direction = if view.projection() == Projection::Parallel { forward } else { offset / z };
        let [right, up] = texel(view);
        Self {
            view: *view,
            z,
            depth: ((z - view.near) / (view.far - view.near)).min(1.0),
            along: normal.dot(direction),
            across: Vec2::new(normal.dot(right), normal.dot(up)),
            least: if normal == Vec3::ZERO { -1.0 } else { 0.0 },
        }
    }

    /// Returns whether the surface faces away from the light.
    pub fn is_turned(&self) -> bool {
        self.across != Vec2::ZERO && self.along >= 0.0
    }

    /// Returns whether a texel with depth `hit`, whose centre is `apart` from the point in texels, blocks the point's light.
    /// Twin: opaque_ends.
    pub fn is_ended(&self, hit: f32, apart: Vec2) -> bool {
        let z = self.view.near + hit * (self.view.far - self.view.near);
        let spread = if self.view.projection() == Projection::Parallel { 1.0 } else { z };
        hit < self.depth && (z - self.z) * self.along + apart.dot(self.across) * spread > self.least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out by hand: a plane that rises by 1 from texel to texel, under parallel rays straight down.
    #[test]
    fn a_slope_is_no_step() {
        let view = View {
            origin: [0.0; 3],
            projection: Projection::Parallel as u32,
            right: [1.0, 0.0, 0.0],
            scale_x: 0.5,
            up: [0.0, 1.0, 0.0],
            scale_y: 0.5,
            forward: [0.0, 0.0, 1.0],
            near: 0.0,
            far: 8.0,
            width: 4,
            height: 4,
        };
        let normal = Vec3::new(-1.0, 0.0, -1.0).normalize();
        let point = Vec3::new(0.0, 0.0, 4.0);
        let at = moved(&view, point, normal, 0.1);
        assert!((at - point - 0.1 * normal.x.abs() * normal).length() < 1e-6, "{at}");
        let [surface, space] = [normal, Vec3::ZERO].map(|normal| Receiver::new(&view, at, normal));
        let apart = Vec2::new(0.5, 0.0);
        // Three texels in turn: the first holds the plane itself, the second a mesh above the plane, and the third a mesh above the plane
        // but deeper than the point.
        for (hit, ends) in [(3.5, [false, true]), (3.2, [true, true]), (4.1, [false, false])] {
            assert_eq!([surface, space].map(|of| of.is_ended(hit / 8.0, apart)), ends, "{hit}");
        }
        assert!(!surface.is_turned() && !space.is_turned() && Receiver::new(&view, at, -normal).is_turned());
    }
}
