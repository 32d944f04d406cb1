//! CPU twin of glsl/technique/ray_query/boxes.comp: a box about each caster, in f32.

use super::gaussian::strand_axis;
use crate::scene::Caster;
use glam::Vec3;

/// Twin: BOX_MARGIN.
const MARGIN: f32 = 1e-5;

/// Low and high corner of the box about a caster; none for a caster that casts nothing.
pub fn boxed(caster: &Caster) -> Option<[[f32; 3]; 2]> {
    let (start, end) = (Vec3::from(caster.position), Vec3::from(caster.position) + strand_axis(caster));
    let margin = caster.radius + MARGIN * (caster.radius + start.abs().max(end.abs()));
    let of = [start.min(end) - margin, start.max(end) + margin];
    (caster.radius > 0.0).then(|| of.map(|corner| corner.to_array()))
}
