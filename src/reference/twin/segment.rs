//! CPU twin of glsl/maps/segment.glsl: the segment that a caster cuts out of a texel's light ray, in f32.

use super::cell;
use super::splat::{AlongRay, CHORD, turned};
use crate::scene::{Caster, Projection, View};
use glam::{Vec2, Vec3};

/// Twin: MAX_OPTICAL_DEPTH in glsl/world/caster.glsl.
pub const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// Twin: EDGE_ON in glsl/world/caster.glsl.
const EDGE_ON: f32 = 1e-10;

/// A segment of a light ray inside a caster; a strand's segment has no length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Depth in the light's range.
    pub entry: f32,
    /// Depth in the light's range, ≥ `entry`.
    pub exit: f32,
    /// Optical depth of the segment.
    pub optical_depth: f32,
}

/// Returns the origin and direction of the ray through a point given in texels. Twin: view_ray.
pub(super) fn ray(view: &View, texel: Vec2) -> (Vec3, Vec3) {
    let ndc = texel / Vec2::new(view.width as f32, view.height as f32) * 2.0 - 1.0;
    let (right, up, forward) = (Vec3::from(view.right), Vec3::from(view.up), Vec3::from(view.forward));
    let across = right * (ndc.x / view.scale_x) + up * (ndc.y / view.scale_y);
    match view.projection() {
        Projection::Parallel => (Vec3::from(view.origin) + across, forward),
        Projection::Perspective => (Vec3::from(view.origin), forward + across),
    }
}

/// Returns three values for a ray and a strand: the part of the strand's start perpendicular to the ray, the same part of its axis, and the
/// position along the axis that is nearest to the ray. The position is `None` if the strand points along the ray. Twin: strand_along.
pub(super) fn strand_along((origin, direction): (Vec3, Vec3), strand: &Caster) -> (Vec3, Vec3, Option<f32>) {
    let scale = 1.0 / direction.dot(direction);
    let (offset, axis) = (Vec3::from(strand.position) - origin, Vec3::from(strand.axis));
    let start = offset - offset.dot(direction) * scale * direction;
    let across = axis - axis.dot(direction) * scale * direction;
    let square = across.dot(across);
    let along = (square > EDGE_ON * axis.dot(axis)).then(|| -start.dot(across) / square);
    (start, across, along)
}

/// Returns the z at which a ray meets a strand. Twin: strand_overlap.
fn strand_step(ray: (Vec3, Vec3), strand: &Caster) -> Option<f32> {
    let (start, axis, along) = strand_along(ray, strand);
    let along = along.filter(|along| (0.0..1.0).contains(along))?;
    let across = start + along * axis;
    let (offset, direction) = (Vec3::from(strand.position) - ray.0, ray.1);
    let z = (offset.dot(direction) + along * Vec3::from(strand.axis).dot(direction)) / direction.dot(direction);
    (across.dot(across) < strand.radius * strand.radius).then_some(z)
}

/// Returns the segment of a caster on a texel's ray; `None` if the ray misses the caster or leaves it before the near plane.
/// Twin: texel_segment.
pub fn texel_segment(view: &View, texel: [u32; 2], caster: &Caster) -> Option<Segment> {
    let (about, caster) = about_origin(view, caster);
    segment_at(&about, Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5, &caster)
}

/// Returns view and caster, both moved so that the view's origin is 0.
pub(super) fn about_origin(view: &View, caster: &Caster) -> (View, Caster) {
    let position = (Vec3::from(caster.position) - Vec3::from(view.origin)).into();
    (View { origin: [0.0; 3], ..*view }, Caster { position, ..*caster })
}

/// Returns the segment of the ray through a point given in texels; `view` is at the world origin.
pub(super) fn segment_at(view: &View, at: Vec2, caster: &Caster) -> Option<Segment> {
    let (origin, direction) = ray(view, at);
    let depth = |z: f32| (z - view.near) / (view.far - view.near);
    if caster.is_strand() {
        let z = strand_step((origin, direction), caster).filter(|z| *z > view.near)?;
        return Some(Segment { entry: depth(z), exit: depth(z), optical_depth: caster.density });
    }
    if caster.is_splat() {
        let (right, up, forward) = (Vec3::from(view.right), Vec3::from(view.up), Vec3::from(view.forward));
        let axes = |v: Vec3| Vec3::new(v.dot(right), v.dot(up), v.dot(forward));
        let caster = Caster { position: axes(caster.position.into()).into(), ..turned(view, caster) };
        return splat_segment(view, (axes(origin), axes(direction)), &caster);
    }
    if caster.is_cell() {
        let (right, up, forward) = (Vec3::from(view.right), Vec3::from(view.up), Vec3::from(view.forward));
        let axes = |v: Vec3| Vec3::new(v.dot(right), v.dot(up), v.dot(forward));
        let caster = Caster { position: axes(caster.position.into()).into(), ..turned(view, caster) };
        let [low, high, long] = cell::overlap((axes(origin), axes(direction)), &caster)?;
        return segment_within(view, direction.length(), caster.density, [low, high, long]);
    }
    let offset = Vec3::from(caster.position) - origin;
    let scale = 1.0 / direction.dot(direction);
    let middle = offset.dot(direction) * scale;
    let rest = offset - middle * direction;
    let half_square = (caster.radius * caster.radius - rest.dot(rest)) * scale;
    if half_square.is_nan() || half_square <= 0.0 {
        return None;
    }
    let half = half_square.sqrt();
    segment_within(view, direction.length(), caster.density, [middle - half, middle + half, 2.0 * half])
}

/// Returns a segment of uniform extinction from z `low` to `high`, of which a length `long` in z counts. Twin: segment_cut.
fn segment_within(view: &View, ray_length: f32, extinction: f32, [low, high, long]: [f32; 3]) -> Option<Segment> {
    let depth = |z: f32| (z - view.near) / (view.far - view.near);
    if high <= view.near {
        return None;
    }
    let (low, long) = if low < view.near { (view.near, high - view.near) } else { (low, long) };
    let whole = extinction * long * ray_length;
    let optical_depth = whole.min(MAX_OPTICAL_DEPTH);
    let high = if whole > MAX_OPTICAL_DEPTH { low + long * (MAX_OPTICAL_DEPTH / whole) } else { high };
    Some(Segment { entry: depth(low), exit: depth(high), optical_depth })
}

/// Returns the segment of a splat; `ray` and `caster` are in the view's axes, as from view_caster. Twin: splat_overlap and segment_cut.
fn splat_segment(view: &View, ray: (Vec3, Vec3), caster: &Caster) -> Option<Segment> {
    let along = AlongRay::of(ray, caster);
    let half = (CHORD * along.deviation).min(along.half());
    let (mut low, mut high) = (along.middle - half, along.middle + half);
    if half.is_nan() || half <= 0.0 || high <= view.near {
        return None;
    }
    let mut whole = caster.density * along.length() * ray.1.length();
    if low < view.near {
        whole *= (high - view.near) / (high - low);
        low = view.near;
    }
    if whole > MAX_OPTICAL_DEPTH {
        high = low + (high - low) * (MAX_OPTICAL_DEPTH / whole);
    }
    let depth = |z: f32| (z - view.near) / (view.far - view.near);
    Some(Segment { entry: depth(low), exit: depth(high), optical_depth: whole.min(MAX_OPTICAL_DEPTH) })
}

/// Sorts as the lists of glsl/maps/list/ do: by entry depth, with ties broken by exit, optical depth and caster index.
pub fn sort(segments: &mut [(u32, Segment)]) {
    let key = |of: fn(&Segment) -> f32| move |a: &Segment, b: &Segment| of(a).total_cmp(&of(b));
    let (entry, exit, depth) = (key(|s| s.entry), key(|s| s.exit), key(|s| s.optical_depth));
    segments.sort_by(|(i, a), (j, b)| {
        entry(a, b).then_with(|| exit(a, b)).then_with(|| depth(a, b)).then_with(|| i.cmp(j))
    });
}
