//! CPU twin of glsl/list/capture.frag: the segment that a particle cuts out of a texel's light ray, in f32.

use crate::scene::{Particle, Projection, View};
use glam::{Vec2, Vec3};

/// Twin: MAX_OPTICAL_DEPTH in glsl/common/particle.glsl.
pub const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// A segment of a light ray inside a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Depth in the light's range.
    pub entry: f32,
    /// Depth in the light's range, ≥ `entry`.
    pub exit: f32,
    /// Optical depth of the segment.
    pub optical_depth: f32,
}

/// Twin: texel_segment. None where the ray misses the particle or leaves it before the near plane.
pub fn texel_segment(view: &View, texel: [u32; 2], particle: &Particle) -> Option<Segment> {
    let size = Vec2::new(view.width as f32, view.height as f32);
    let ndc = (Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5) / size * 2.0 - 1.0;
    let (right, up, forward) = (Vec3::from(view.right), Vec3::from(view.up), Vec3::from(view.forward));
    let across = right * (ndc.x / view.scale_x) + up * (ndc.y / view.scale_y);
    let (origin, direction) = match view.projection() {
        Projection::Parallel => (Vec3::from(view.origin) + across, forward),
        Projection::Perspective => (Vec3::from(view.origin), forward + across),
    };
    let offset = Vec3::from(particle.position) - origin;
    let scale = 1.0 / direction.dot(direction);
    let middle = offset.dot(direction) * scale;
    let rest = offset - middle * direction;
    let half_square = (particle.radius * particle.radius - rest.dot(rest)) * scale;
    if half_square.is_nan() || half_square <= 0.0 {
        return None;
    }
    let (low, high) = (middle - half_square.sqrt(), middle + half_square.sqrt());
    if high <= view.near {
        return None;
    }
    let low = low.max(view.near);
    let depth = |z: f32| (z - view.near) / (view.far - view.near);
    let whole = particle.extinction * (high - low) * direction.length();
    let optical_depth = whole.min(MAX_OPTICAL_DEPTH);
    let high = if whole > MAX_OPTICAL_DEPTH { low + (high - low) * (MAX_OPTICAL_DEPTH / whole) } else { high };
    Some(Segment { entry: depth(low), exit: depth(high), optical_depth })
}

/// Sorts as glsl/list/ lists are sorted: by entry depth, ties by particle index.
pub fn sort(segments: &mut [(u32, Segment)]) {
    segments.sort_by(|a, b| a.1.entry.total_cmp(&b.1.entry).then(a.0.cmp(&b.0)));
}
