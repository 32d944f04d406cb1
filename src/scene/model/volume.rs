//! Volumes: a field of densities placed in the world, and the cells that represent it as casters on the device.

use crate::scene::model::splat::{EXPONENT, OCTAVES, packed};
use crate::scene::{Caster, Field};
use glam::DVec3;
use std::sync::Arc;

/// The exponent bits of 2^101 in a caster's axis mark a cell. Twin: CELL_MARK.
pub(super) const CELL_MARK: u32 = 0x7200_0000;

/// The largest number of casters per volume. Above it, each caster represents 2³, 4³ or 8³ of the field's cells.
pub const MOST_CELLS: usize = 4_000_000;

/// The maximum ratio of a cell's longest side to its shortest.
const LONGEST: f64 = 1000.0;

/// Where a volume's samples are, and how densities turn into extinction and color.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Position of sample (0, 0, 0), in world units.
    pub origin: DVec3,
    /// Steps from one sample to the next along each of the field's axes, in world units; perpendicular to each other.
    pub steps: [DVec3; 3],
    /// Extinction at density 1, in 1 / world unit, finite and > 0.
    pub extinction: f64,
    /// Albedo, red, green, blue, in [0, 1].
    pub color: [f32; 3],
    /// Number of the field's cells that one caster spans along each axis: 1, 2, 4 or 8. It is raised if there would be more than
    /// [`MOST_CELLS`] casters.
    pub side: u32,
}

/// A placed field that casts shadows.
#[derive(Clone, Debug)]
pub struct Volume {
    field: Arc<Field>,
    placed: Placed,
    cells: Arc<[Caster]>,
}

impl PartialEq for Volume {
    fn eq(&self, other: &Self) -> bool {
        let same_field = Arc::ptr_eq(&self.field, &other.field) || self.field == other.field;
        self.placed == other.placed && self.cells.len() == other.cells.len() && same_field
    }
}

impl Volume {
    /// Places a field.
    ///
    /// Returns an error message if the steps are not perpendicular, have no length or differ too much in length, if the extinction is not a
    /// valid float, or if numbers are out of range.
    pub fn new(field: Arc<Field>, placed: Placed) -> Result<Self, String> {
        let steps = placed.steps;
        let lengths = steps.map(DVec3::length);
        if lengths.iter().any(|length| !(1e-12..=1e15).contains(length)) {
            return Err(format!("steps of {lengths:?} world units are not within 1e-12 and 1e15"));
        }
        let longest = lengths.into_iter().fold(0.0, f64::max);
        if lengths.iter().any(|length| longest > LONGEST * length) {
            return Err(format!(
                "steps of {lengths:?} world units are more than {LONGEST} times as long as each other"
            ));
        }
        if (0..3).any(|i| steps[i].dot(steps[(i + 1) % 3]).abs() > 1e-5 * lengths[i] * lengths[(i + 1) % 3]) {
            return Err(format!("its axes {steps:?} are not at right angles to each other"));
        }
        if !(1e-30..=1e30).contains(&placed.extinction) {
            return Err(format!("extinction {} is not within 1e-30 and 1e30", placed.extinction));
        }
        if ![1, 2, 4, 8].contains(&placed.side) {
            return Err(format!("cells of {} a side: give 1, 2, 4 or 8", placed.side));
        }
        let mut side = placed.side;
        let mut count = field.cubes(side as usize).count();
        while side < 8 && count > MOST_CELLS {
            side *= 2;
            count = field.cubes(side as usize).count();
        }
        let mut volume = Self { field, placed, cells: Arc::default() };
        // A list that grows would take up to three times the memory.
        let mut cells = Vec::with_capacity(count);
        cells.extend(volume.field.cubes(side as usize).map(|cube| volume.cell(cube, side)));
        volume.cells = cells.into();
        let numbers = |cell: &Caster| cell.position.into_iter().chain([cell.radius, cell.density]);
        if volume.cells.iter().flat_map(numbers).any(|v| !(v.is_finite() && v.abs() <= 1e18)) {
            return Err("it reaches farther, or takes more, than 1e18".into());
        }
        Ok(volume)
    }

    /// Returns the volume's densities.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Returns a weak reference to the densities, for a test of whether anything still holds them.
    #[cfg(test)]
    pub(crate) fn held(&self) -> std::sync::Weak<Field> {
        Arc::downgrade(&self.field)
    }

    /// Returns the volume's placement.
    pub fn placed(&self) -> &Placed {
        &self.placed
    }

    /// Returns the casters that represent the volume on the device, each with its mean density, rounded to f32 once.
    pub fn cells(&self) -> &[Caster] {
        &self.cells
    }

    /// Keeps only the first `most` casters, for quick tests; the field stays complete.
    #[cfg(feature = "program")]
    pub(crate) fn truncate(&mut self, most: usize) {
        self.cells = self.cells.iter().take(most).copied().collect();
    }

    /// Builds the caster for a cube of cells, from its lowest sample and mean density.
    fn cell(&self, (first, density): ([i32; 3], f64), side: u32) -> Caster {
        let half = 0.5 * f64::from(side);
        let place = |axis: usize| self.placed.steps[axis] * (f64::from(first[axis]) + half);
        let centre = self.placed.origin + place(0) + place(1) + place(2);
        cell(centre, self.placed.steps.map(|step| step * half), density * self.placed.extinction)
    }
}

/// Builds a box-shaped caster from its centre and three half-extent vectors, which are perpendicular. If the sides differ in length,
/// packing rounds them by at most 0.11 %. The extinction is adjusted to compensate, so that extinction times volume is exact.
pub(crate) fn cell(centre: DVec3, halves: [DVec3; 3], extinction: f64) -> Caster {
    let mut sides = halves;
    sides.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    let lengths = sides.map(DVec3::length);
    let octaves = |i: usize| ((lengths[0] / lengths[i]).log2() / OCTAVES * 4095.0).round().clamp(0.0, 4095.0) as u32;
    let octaves = [octaves(1), octaves(2)];
    let shares = [0, octaves[0], octaves[1]].map(|o| (-OCTAVES / 4095.0 * f64::from(o)).exp2());
    let radius = (lengths[0] * shares.iter().map(|s| s * s).sum::<f64>().sqrt()) as f32;
    let rounded = lengths[0] * shares[1] / lengths[1] * (lengths[0] * shares[2] / lengths[2]);
    Caster {
        position: centre.as_vec3().into(),
        radius,
        axis: packed(CELL_MARK, sides[2] / lengths[2], sides[0] / lengths[0], octaves),
        density: (extinction / rounded) as f32,
    }
}

impl Caster {
    /// Returns whether the caster is a cell of a volume.
    pub fn is_cell(&self) -> bool {
        self.axis[0].to_bits() & EXPONENT == CELL_MARK
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shape;

    fn placed() -> Placed {
        Placed {
            origin: DVec3::ZERO,
            steps: [DVec3::X, 2.0 * DVec3::Y, 0.25 * DVec3::Z],
            extinction: 3.0,
            color: [1.0; 3],
            side: 1,
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let field = Arc::new(Field::new([([0; 3], 1.0)]).expect("a field"));
        let of = |placed: Placed| Volume::new(field.clone(), placed).map(|v| v.cells().len());
        assert_eq!(of(placed()), Ok(8));
        let skewed = [DVec3::X, DVec3::new(0.1, 1.0, 0.0), DVec3::Z];
        for (wrong, word) in [
            (Placed { steps: skewed, ..placed() }, "right angles"),
            (Placed { steps: [DVec3::X, DVec3::Y, DVec3::ZERO], ..placed() }, "world units"),
            (Placed { steps: [DVec3::X, DVec3::Y, 1e-4 * DVec3::Z], ..placed() }, "1000 times"),
            (Placed { extinction: 0.0, ..placed() }, "extinction 0"),
            (Placed { extinction: f64::NAN, ..placed() }, "extinction NaN"),
            (Placed { extinction: 1e30, ..placed() }, "1e18"),
            (Placed { origin: 1e20 * DVec3::X, ..placed() }, "1e18"),
            (Placed { side: 3, ..placed() }, "1, 2, 4 or 8"),
        ] {
            let error = of(wrong).expect_err(word);
            assert!(error.contains(word), "{error}");
        }
    }

    /// Checks the sides and axes of the cells. Extinction times volume, summed over all cells, must equal the field's total despite
    /// rounding.
    #[test]
    fn cells_are_boxes_of_what_is_in_them() {
        let field = Arc::new(Field::new([([1, 1, 1], 2.0)]).expect("a field"));
        for side in [1, 2, 4, 8] {
            let volume = Volume::new(field.clone(), Placed { side, ..placed() }).expect("a volume");
            let mass: f64 = volume
                .cells()
                .iter()
                .map(|cell| {
                    assert!(cell.is_cell() && !cell.is_splat() && !cell.is_strand());
                    let shape = Shape::of_cell(cell);
                    let long = f64::from(side);
                    for (found, expected) in shape.deviations.into_iter().zip([long, 0.5 * long, 0.125 * long]) {
                        assert!((found / expected - 1.0).abs() < 0.0012, "{found} {expected}");
                    }
                    assert!(shape.axes[0].y.abs() > 0.999_999 && shape.axes[2].z.abs() > 0.999_999);
                    8.0 * shape.deviations.iter().product::<f64>() * f64::from(cell.density)
                })
                .sum();
            // Expected: a sample of density 2, times the volume 1 × 2 × ¼ of a field cell, times extinction 3.
            assert!((mass - 3.0).abs() < 1e-4, "{side}: {mass}");
        }
    }
}
