//! Grids whose axes are not at right angles, sampled along axes that are.
//!
//! A sheared map is a turn, steps, and a shear that moves each row of samples along itself, by a different share of a sample for each row
//! (its QR decomposition; the shear is the triangular part divided by its diagonal). Linear interpolation along the rows undoes the shear
//! and keeps the sum of all samples.

use crate::scene::{CORNERS, Field, SIDE};
use fnv::FnvHashMap;
use glam::DVec3;

/// The cosine between two axes up to which they are at right angles. A [`crate::scene::Volume`] accepts as much.
const RIGHT: f64 = 1e-5;

/// The largest shift of a row, in samples, so that a damaged map does not spread a field over all space.
const MOST_SHIFT: f64 = 4096.0;

/// The farthest that a sample may be from sample 0 of the straight grid.
const FARTHEST: f64 = 16_777_216.0;

/// Returns by how many degrees the axes deviate from right angles; `None` if they do not.
pub(in crate::scene) fn sheared_by(steps: &[DVec3; 3]) -> Option<f64> {
    let cosine = |i: usize| steps[i].dot(steps[(i + 1) % 3]) / (steps[i].length() * steps[(i + 1) % 3].length());
    let largest = (0..3).map(|i| cosine(i).abs()).fold(0.0, f64::max);
    (largest > RIGHT).then(|| largest.asin().to_degrees())
}

/// Returns the field along straight axes, with their steps. Sample (0, 0, 0) stays where it is.
///
/// # Errors
/// A message if the axes lie in a plane, or the field becomes too large.
pub(in crate::scene) fn straightened(field: &Field, steps: &[DVec3; 3]) -> Result<(Field, [DVec3; 3]), String> {
    let [x, y, z] = *steps;
    let along = x.normalize();
    let across = y - y.dot(along) * along;
    let aside = across.normalize();
    let above = z - z.dot(along) * along - z.dot(aside) * aside;
    // How far, in samples of the straight grid, one step along y moves along x, and one along z along x and y.
    let shear = [y.dot(along) / x.length(), z.dot(along) / x.length(), z.dot(aside) / across.length()];
    let volume = along.cross(aside).dot(above).abs() * across.length() * x.length();
    if !(volume > 1e-6 * x.length() * y.length() * z.length() && shear.iter().all(|s| s.abs() < MOST_SHIFT)) {
        return Err(format!("its axes {steps:?} lie in a plane"));
    }
    // Each sample goes to four places: two rows, two places in each.
    let mut sums: FnvHashMap<[i32; 3], f32> = FnvHashMap::default();
    let mut add = |place: [i32; 3], density: f64| *sums.entry(place).or_default() += density as f32;
    for ([i, j, k], density) in samples(field) {
        let along = f64::from(j) + shear[2] * f64::from(k);
        let at = f64::from(i) + shear[0] * f64::from(j) + shear[1] * f64::from(k);
        if along.abs().max(at.abs()) > FARTHEST {
            return Err(format!("its shear moves sample {:?} farther than {FARTHEST} samples", [i, j, k]));
        }
        for (row, of_row) in shares(along) {
            for (place, of_place) in shares(at) {
                add([place, row, k], f64::from(density) * of_row * of_place);
            }
        }
    }
    Ok((Field::new(sums)?, [x, across, above]))
}

/// Returns the two whole numbers around a number, each with its share.
fn shares(at: f64) -> [(i32, f64); 2] {
    let low = at.floor();
    let share = at - low;
    [(low as i32, 1.0 - share), (low as i32 + 1, share)]
}

/// Returns all samples that are not 0.
fn samples(field: &Field) -> impl Iterator<Item = ([i32; 3], f32)> {
    field.blocks().flat_map(|(at, samples)| {
        let place = move |i: usize| [i % CORNERS, i / CORNERS % CORNERS, i / CORNERS / CORNERS];
        let own = samples.iter().enumerate().map(move |(i, density)| (place(i), *density));
        // The last samples of a block are the first of the next.
        let own = own.filter(|(offset, density)| *density != 0.0 && offset.iter().all(|o| *o < SIDE));
        own.map(move |(offset, density)| ([0, 1, 2].map(|axis| at[axis] + offset[axis] as i32), density))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Densities of a box of samples; their sum and their middle in space must stay, and where they are constant they must.
    #[test]
    fn what_is_sheared_keeps_its_place() {
        let box_of = |at: [i32; 3]| (0..3).all(|axis| (-5..9).contains(&at[axis]));
        let all = (0..24i32.pow(3)).map(|i| [i % 24 - 10, i / 24 % 24 - 10, i / 576 - 10]);
        let field = Field::new(all.map(|at| (at, if box_of(at) { 0.25 } else { 0.0 }))).expect("a field");
        let tilted = [DVec3::new(0.5, 0.1, 0.0), DVec3::new(0.25, 1.0, 0.1), DVec3::new(0.3, -0.4, 2.0)];
        let moments = |field: &Field, steps: &[DVec3; 3]| {
            let (mut sum, mut middle) = (0.0, DVec3::ZERO);
            for (at, density) in samples(field) {
                sum += f64::from(density);
                let place = (0..3).map(|axis| steps[axis] * f64::from(at[axis])).sum::<DVec3>();
                middle += f64::from(density) * place;
            }
            (sum, middle / sum)
        };
        assert!(sheared_by(&tilted).is_some_and(|degrees| degrees > 10.0));
        let (straight, steps) = straightened(&field, &tilted).expect("a field");
        assert_eq!(sheared_by(&steps), None);
        let ((sum, middle), (of_straight, moved)) = (moments(&field, &tilted), moments(&straight, &steps));
        assert!((of_straight / sum - 1.0).abs() < 1e-5, "{sum} and {of_straight}");
        assert!((moved - middle).length() < 1e-4, "{middle} and {moved}");
        let determinant = |[x, y, z]: [DVec3; 3]| x.cross(y).dot(z);
        assert!((determinant(steps) / determinant(tilted) - 1.0).abs() < 1e-9);
        // In the box's middle all is 0.25.
        assert!((straight.at([2.0, 2.0, 2.0]) - 0.25).abs() < 1e-6);
        assert!(straightened(&field, &[DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)]).is_err());
    }
}
