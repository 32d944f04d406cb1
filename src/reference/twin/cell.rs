//! CPU twin of glsl/world/cell.glsl: optical depth of a volume's cell along a ray, in f32.

use super::gaussian::shape as gaussian_shape;
use crate::scene::{Caster, FARTHEST};
use glam::Vec3;

/// Unit vectors and half of the sides along them. Twin: cell_shape.
pub fn shape(caster: &Caster) -> ([Vec3; 3], Vec3) {
    let (axes, sides) = gaussian_shape(&Caster { radius: 3.0, ..*caster });
    (axes, sides * (caster.radius * (1.0 / sides.dot(sides).sqrt())))
}

/// z from which and to which a ray is inside, and how long. Twin: cell_overlap.
pub fn overlap((origin, direction): (Vec3, Vec3), caster: &Caster) -> Option<[f32; 3]> {
    let (axes, sides) = shape(caster);
    let offset = Vec3::from(caster.position) - origin;
    let nearest = offset.dot(direction) / direction.dot(direction);
    let across = offset - nearest * direction;
    let (mut low, mut high) = (-FARTHEST, FARTHEST);
    for (axis, side) in axes.into_iter().zip(sides.to_array()) {
        let along = axis.dot(direction);
        let along = if along.abs() < 1e-12 { 1e-12 } else { along };
        let from = axis.dot(across);
        let reach = if along < 0.0 { -side } else { side };
        low = low.max((from - reach) / along);
        high = high.min((from + reach) / along);
    }
    (high > low).then_some([nearest + low, nearest + high, high - low])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Field, Placed, Volume};
    use glam::{DQuat, DVec3};
    use proptest::prelude::*;
    use std::sync::Arc;

    proptest! {
        /// Against a sum of steps: a place is inside where it is within half a side of the middle along each axis.
        #[test]
        fn is_inside_the_box(
            from in prop::array::uniform3(-3.0f64..3.0),
            to in prop::array::uniform3(-0.6f64..0.6),
            turn in prop::array::uniform4(-1.0f64..1.0),
            steps in prop::array::uniform3(0.1f64..1.0),
        ) {
            prop_assume!(turn.iter().map(|x| x * x).sum::<f64>() > 0.01);
            let turn = DQuat::from_array(turn).normalize();
            let steps = [DVec3::X * steps[0], DVec3::Y * steps[1], DVec3::Z * steps[2]].map(|s| turn * s);
            let placed = Placed { origin: DVec3::ZERO, steps, extinction: 1.0, color: [1.0; 3], side: 1 };
            let field = Field::new([([0, 0, 0], 1.0)]).expect("a field");
            let volume = Volume::new(Arc::new(field), placed).expect("a volume");
            let cell = volume.cells()[0];
            let middle = DVec3::from(cell.position.map(f64::from));
            let (from, towards) = (DVec3::from(from), middle + DVec3::from(to));
            let way = towards - from;
            prop_assume!(way.length() > 0.1);
            let count = 20_000;
            // Sides are rounded by 0.11 % and axes by 5e-5 rad, which moves a side by that share of the radius: a ray beside an edge, or
            // along a side, may have much of it.
            let rounded = |step: &DVec3| 0.5 * 0.0011 + 5e-5 * f64::from(cell.radius) / step.length();
            let inside = |sign: f64| {
                let inside = (0..count).filter(|i| {
                    let offset = from + way * (4.0 * (f64::from(*i) + 0.5) / f64::from(count)) - middle;
                    let within = |step: &DVec3| (offset.dot(*step) / step.length_squared()).abs() < 0.5 + sign * rounded(step);
                    steps.iter().all(within)
                });
                inside.count() as f64 / f64::from(count) * 4.0
            };
            // Two steps, in which the ray enters and leaves.
            let expected = inside(-1.0) - 8.0 / f64::from(count)..=inside(1.0) + 8.0 / f64::from(count);
            let found = overlap((from.as_vec3(), way.as_vec3()), &cell);
            let found = found.filter(|z| z[0] > 0.0 && z[1] < 4.0).map_or(0.0, |z| z[2]);
            // A ray that begins or ends inside is another matter.
            let ends = [from - middle, from + 4.0 * way - middle];
            prop_assume!(ends.iter().all(|end| end.length() > f64::from(cell.radius)));
            prop_assert!(expected.contains(&f64::from(found)), "{found}, not in {expected:?}");
        }
    }
}
