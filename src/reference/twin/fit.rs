//! CPU twin of glsl/maps/aim.comp, bounds.comp and fit.comp: views given their lights' positions and directions and fitted to the scene, in
//! f32.

use super::order::{float_of_order, float_order};
use crate::scene::{Caster, Projection, View};
use glam::{Vec2, Vec3};

/// The data of a light from which its views are aimed.
#[derive(Clone, Copy, Debug)]
pub struct Aiming {
    /// Position; `None` for a directional light.
    pub position: Option<[f32; 3]>,
    /// Direction; `None` for a light with six maps.
    pub direction: Option<[f32; 3]>,
    /// Cosine of half the cone of a spot light.
    pub cos_cone: Option<f32>,
}

/// Gives a view the position, direction and cone of `light`; the view was built for a light of the same kind. Twin: glsl/maps/aim.comp.
pub fn aim(mut view: View, light: &Aiming) -> View {
    view.origin = light.position.unwrap_or(view.origin);
    let Some(direction) = light.direction else { return view };
    let forward = Vec3::from(direction);
    let across = if forward.z.abs() < 0.99 {
        Vec3::new(forward.y, -forward.x, 0.0)
    } else {
        Vec3::new(-forward.z, 0.0, forward.x)
    };
    let right = across / across.dot(across).sqrt();
    (view.right, view.up, view.forward) = (right.into(), right.cross(forward).into(), direction);
    if let Some(cosine) = light.cos_cone {
        let scale = cosine / ((1.0 - cosine) * (1.0 + cosine)).sqrt();
        (view.scale_x, view.scale_y) = (scale, scale);
    }
    view
}

/// A box along a view's right, up and forward axes; if it is empty, `low` is above `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Low corner, in world units from the view's origin.
    pub low: Vec3,
    /// High corner, in world units from the view's origin.
    pub high: Vec3,
}

/// Twin: MARGIN and ROUNDING.
const MARGIN: f32 = 1.00001;
const ROUNDING: f32 = 5e-7;
const THINNEST: f32 = 1e-3;

impl Range {
    /// An empty range.
    pub const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn include(&mut self, centre: Vec3, radius: f32) {
        // The device computes minima and maxima of floats as integers.
        let through = |v: Vec3| Vec3::from(v.to_array().map(|c| float_of_order(float_order(c))));
        self.low = self.low.min(through(centre - radius));
        self.high = self.high.max(through(centre + radius));
    }
}

fn axes(view: &View, position: Vec3) -> Vec3 {
    let offset = position - Vec3::from(view.origin);
    Vec3::new(offset.dot(view.right.into()), offset.dot(view.up.into()), offset.dot(view.forward.into()))
}

/// Returns whether the view may see a sphere. Twin: sees.
fn sees(view: &View, centre: Vec3, radius: f32) -> bool {
    let tangent = 1.0 / view.scale_x;
    let outside = centre.x.abs().max(centre.y.abs()) - tangent * centre.z;
    let radius = radius + 1e-5 * (centre.x.abs() + centre.y.abs() + centre.z.abs());
    outside < radius * (1.0 + tangent * tangent).sqrt() && centre.z + radius > 0.0
}

/// Returns the range of casters in a map's aimed volume view, and of mesh vertices in its opaque view. Twin: glsl/maps/bounds.comp.
pub fn bounds([view, opaque_view]: [&View; 2], casters: &[Caster], vertices: &[[f32; 3]]) -> [Range; 2] {
    let (mut translucent, mut opaque) = (Range::NONE, Range::NONE);
    let see_all = view.projection() == Projection::Parallel || casters.iter().any(Caster::is_strand);
    // Casters of radius 0 are unused slots of a list whose length only the device knows.
    for caster in casters.iter().filter(|caster| caster.radius != 0.0) {
        let start = Vec3::from(caster.position);
        let centre = axes(view, start);
        if see_all || sees(view, centre, caster.radius) {
            translucent.include(centre, caster.radius);
        }
        if caster.is_strand() {
            translucent.include(axes(view, start + Vec3::from(caster.axis)), caster.radius);
        }
    }
    vertices.iter().for_each(|v| opaque.include(axes(opaque_view, (*v).into()), 0.0));
    [translucent, opaque]
}

/// Fits a map's aimed volume view and opaque view to the ranges of casters and meshes. Twin: glsl/maps/fit.comp.
pub fn fit([volume, opaque]: [View; 2], [casters, meshes]: [Range; 2], only_meshes: bool) -> [View; 2] {
    let volume = if only_meshes {
        fit_view(View { origin: opaque.origin, ..volume }, meshes)
    } else {
        fit_view(volume, casters)
    };
    [volume, fit_view(opaque, meshes)]
}

/// Narrows a fitted view by 2^`cascade` and centres it in front of a camera at `eye` looking along `ahead`. Twin: narrow.
pub fn narrow(mut view: View, cascade: u32, eye: Vec3, ahead: Vec3) -> View {
    let share = 1.0 / (1u32 << cascade) as f32;
    let whole = 1.0 / Vec2::new(view.scale_x, view.scale_y);
    let half = whole * share;
    let [right, up] = [view.right, view.up].map(Vec3::from);
    let along = |v: Vec3| Vec2::new(v.dot(right), v.dot(up));
    let middle = along(eye - Vec3::from(view.origin)) + half * along(ahead);
    let texel = half * 2.0 / Vec2::new(view.width as f32, view.height as f32);
    let middle = (middle.clamp(half - whole, whole - half) / texel).round() * texel;
    view.origin = (Vec3::from(view.origin) + right * middle.x + up * middle.y).into();
    (view.scale_x, view.scale_y) = (1.0 / half.x, 1.0 / half.y);
    view
}

fn fit_view(mut view: View, mut range: Range) -> View {
    if view.projection() == Projection::Perspective {
        let high = range.high.z.max(1e-3);
        let near = (range.low.z - ROUNDING * high).max(high * view.near).min(high * 0.999);
        view.far = near + ((high - near) * MARGIN + ROUNDING * high) * view.far;
        view.near = near;
        return view;
    }
    if range.low.x > range.high.x {
        range = Range { low: Vec3::ZERO, high: Vec3::ONE };
    }
    let origin = Vec3::from(view.origin);
    let middle = (range.low + range.high) * 0.5;
    let rounding = ROUNDING * origin.abs().max_element();
    let mut half = ((range.high - range.low) * 0.5 * MARGIN + rounding).max(Vec3::splat(1e-6));
    half.z = half.z.max(THINNEST * half.x.max(half.y));
    let across = Vec3::from(view.right) * middle.x + Vec3::from(view.up) * middle.y;
    view.origin = (origin + across + Vec3::from(view.forward) * (middle.z - half.z)).into();
    (view.scale_x, view.scale_y) = (1.0 / half.x, 1.0 / half.y);
    (view.near, view.far) = (0.0, 2.0 * half.z * view.far);
    view
}
