//! CPU twin of glsl/world/cell.glsl: optical depth of a volume's cell along a ray, in f32.

use super::splat::shape as splat_shape;
use crate::scene::{Caster, FARTHEST};
use glam::Vec3;

/// Returns a cell's axes as unit vectors, and its half-extents along them. Twin: cell_shape.
pub fn shape(caster: &Caster) -> ([Vec3; 3], Vec3) {
    let (axes, sides) = splat_shape(&Caster { radius: 3.0, ..*caster });
    (axes, sides * (caster.radius * (1.0 / sides.dot(sides).sqrt())))
}

/// Twin: CELL_ALONG.
const ALONG: f32 = 1e-6;

/// Twin: CELL_SOFT.
const SOFT: f32 = 1e-3;

/// Returns the z at which a ray enters and leaves a cell, and the length in z between them. A ray along a face shared by two cells gets
/// only a share of its length in each; the shares add up to 1. Twin: cell_overlap.
pub fn overlap((origin, direction): (Vec3, Vec3), caster: &Caster) -> Option<[f32; 3]> {
    let (axes, sides) = shape(caster);
    let offset = Vec3::from(caster.position) - origin;
    let square = direction.dot(direction);
    let (nearest, least, mut share) = (offset.dot(direction) / square, ALONG * square.sqrt(), 1.0f32);
    let across = offset - nearest * direction;
    let (mut low, mut high) = (-FARTHEST, FARTHEST);
    for (axis, side) in axes.into_iter().zip(sides.to_array()) {
        let along = axis.dot(direction);
        let from = axis.dot(across);
        if along.abs() < least {
            share *= (0.5 + (side - from.abs()) / (2.0 * SOFT * side)).clamp(0.0, 1.0);
            continue;
        }
        let reach = if along < 0.0 { -side } else { side };
        low = low.max((from - reach) / along);
        high = high.min((from + reach) / along);
    }
    let (middle, half_chord) = (nearest + 0.5 * (low + high), 0.5 * share * (high - low));
    (half_chord > 0.0).then_some([middle - half_chord, middle + half_chord, 2.0 * half_chord])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Field, Placed, Volume};
    use glam::{DQuat, DVec3};
    use proptest::prelude::*;
    use std::sync::Arc;

    /// Returns the cells of a field whose density is the same everywhere except at its ends.
    fn even(step: f64) -> Vec<Caster> {
        let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| step * axis);
        let placed = Placed { origin: DVec3::ZERO, steps, extinction: 1.0, color: [1.0; 3], side: 1 };
        let samples = (0..12).flat_map(|x| (0..12).flat_map(move |y| (0..12).map(move |z| ([x, y, z], 1.0))));
        let field = Field::new(samples).expect("a field");
        Volume::new(Arc::new(field), placed).expect("a volume").cells().to_vec()
    }

    /// Rays that run exactly along the faces and edges shared by cells have the same optical depth as rays through the centres of cells: a
    /// ray's shares in adjacent cells add up to 1.
    #[test]
    fn a_ray_along_a_side_is_in_once() {
        // Steps are equal along all axes: otherwise quantization would change the sides by 0.11 %, more than the width over which a side
        // fades.
        for step in [1.0, 0.3] {
            let (cells, step) = (even(step), DVec3::splat(step));
            let depth = |from: DVec3, way: DVec3| {
                let (from, way) = (from.as_vec3(), way.as_vec3());
                let of = |cell: &Caster| overlap((from, way), cell).map_or(0.0, |z| z[2] * cell.density);
                cells.iter().map(of).sum::<f32>() * way.length()
            };
            for way in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(1.0, -1.0, 0.0), DVec3::new(0.0, 0.4, 1.0)] {
                let before = |at: DVec3| at - 40.0 * way;
                let inside = 5.25 * step;
                let expected = depth(before(inside), way);
                assert!(expected > 3.0 * step.min_element() as f32, "{expected}");
                for side in [[5.0, 5.25, 5.25], [5.25, 5.0, 5.25], [5.25, 5.25, 5.0], [5.0, 5.0, 5.25], [5.0; 3]] {
                    let found = depth(before(DVec3::from(side) * step), way);
                    // Allows for the fraction of a step by which a slanted ray's path differs, and for the quantization of sides.
                    let moved = if way.abs().max_element() == 1.0 && way.length() == 1.0 { 0.01 } else { 0.2 };
                    let off = (found - expected).abs() / expected;
                    assert!(off < moved, "{step}, {way}, {side:?}: {found}, not {expected}");
                }
            }
        }
    }

    proptest! {
        /// Compares with a sum over small steps: a point is inside if it is within half a side of the centre along each axis.
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
            // Quantization changes sides by up to 0.11 %, and axes by up to 5e-5 rad, which moves a side by that share of the radius. For a
            // ray near an edge or along a side, this may change much of the length inside the cell.
            let rounded = |step: &DVec3| 0.5 * 0.0011 + 5e-5 * f64::from(cell.radius) / step.length();
            let inside = |sign: f64| {
                let inside = (0..count).filter(|i| {
                    let offset = from + way * (4.0 * (f64::from(*i) + 0.5) / f64::from(count)) - middle;
                    let within = |step: &DVec3| (offset.dot(*step) / step.length_squared()).abs() < 0.5 + sign * rounded(step);
                    steps.iter().all(within)
                });
                inside.count() as f64 / f64::from(count) * 4.0
            };
            // Two steps of tolerance: one where the ray enters, one where it leaves.
            let expected = inside(-1.0) - 8.0 / f64::from(count)..=inside(1.0) + 8.0 / f64::from(count);
            let found = overlap((from.as_vec3(), way.as_vec3()), &cell);
            let found = found.filter(|z| z[0] > 0.0 && z[1] < 4.0).map_or(0.0, |z| z[2]);
            // Rays that start or end inside are left out.
            let ends = [from - middle, from + 4.0 * way - middle];
            prop_assume!(ends.iter().all(|end| end.length() > f64::from(cell.radius)));
            prop_assert!(expected.contains(&f64::from(found)), "{found}, not in {expected:?}");
        }
    }
}
