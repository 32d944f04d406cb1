//! Optical depth of a volume along a ray, in f64: the exact integral of its trilinear densities, cell by cell. Along a ray a cell's density
//! is a cubic, which two-point Gauss quadrature integrates exactly. Empty cells are skipped, eight at a time along each axis.

use crate::scene::{Field, Placed, Ray, SIDE, Volume, trilinear};
use glam::DVec3;

/// A ray in a field's coordinates, where samples are 1 apart.
struct FieldRay {
    origin: DVec3,
    direction: DVec3,
}

/// A cell of a volume along a ray, over depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    /// Depth at which the ray enters the cell.
    pub entry: f64,
    /// Depth at which the ray leaves the cell.
    pub exit: f64,
    /// Optical depth of all cells before this one.
    pub before: f64,
    /// Coefficients of a cubic in u, the share of the cell's length already passed: extinction at u times the whole length.
    pub powers: [f64; 4],
}

impl Cubic {
    /// Scales the optical depth of this cell and of all cells before it.
    pub(super) fn scale(&mut self, factor: f64) {
        self.before *= factor;
        self.powers = self.powers.map(|power| power * factor);
    }

    /// Returns the optical depth up to `depth`, including all cells before this one. `depth` must not precede the cell's entry.
    pub fn optical_depth(&self, depth: f64) -> f64 {
        let u = ((depth - self.entry) / (self.exit - self.entry)).clamp(0.0, 1.0);
        let [a, b, c, d] = self.powers;
        self.before + u * (a + u * (b / 2.0 + u * (c / 3.0 + u * d / 4.0)))
    }
}

impl FieldRay {
    fn of(ray: &Ray, placed: &Placed) -> Self {
        // The axes are orthogonal, so projecting onto each is enough.
        let place = |v: DVec3| DVec3::from_array(placed.steps.map(|step| v.dot(step) / step.length_squared()));
        Self { origin: place(ray.origin - placed.origin), direction: place(ray.direction) }
    }

    fn at(&self, z: f64) -> DVec3 {
        self.origin + z * self.direction
    }

    /// Returns the range of z between `from` and `to` in which the ray is in a box, or `None` if it misses the box.
    fn clipped(&self, low: DVec3, high: DVec3, from: f64, to: f64) -> Option<(f64, f64)> {
        let (mut from, mut to) = (from, to);
        for axis in 0..3 {
            if self.direction[axis] == 0.0 {
                if !(low[axis]..=high[axis]).contains(&self.origin[axis]) {
                    return None;
                }
                continue;
            }
            let ends = [low[axis], high[axis]].map(|end| (end - self.origin[axis]) / self.direction[axis]);
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        (to > from).then_some((from, to))
    }

    /// Visits the cubes of `side` samples per side along the ray, in order, with the z at which the ray enters and leaves each. Source:
    /// Amanatides and Woo 1987.
    fn walk(&self, side: f64, from: f64, to: f64, mut visit: impl FnMut([i32; 3], f64, f64)) {
        let mut cube = (self.at(from) / side).to_array().map(|at| at.floor() as i32);
        let mut z = from;
        while z < to {
            let end = |axis: usize| {
                let direction = self.direction[axis];
                let plane = f64::from(cube[axis] + i32::from(direction > 0.0)) * side;
                if direction == 0.0 { f64::INFINITY } else { (plane - self.origin[axis]) / direction }
            };
            let ends = [end(0), end(1), end(2)];
            let axis = if ends[0] <= ends[1] && ends[0] <= ends[2] { 0 } else { 1 + usize::from(ends[2] < ends[1]) };
            let next = ends[axis].min(to);
            if next > z {
                visit(cube, z, next);
                z = next;
            }
            cube[axis] += if self.direction[axis] > 0.0 { 1 } else { -1 };
        }
    }

    /// Visits all non-empty cells from z `from` to `to`, with each cell's corner densities, its lowest sample, and the z at which the ray
    /// enters and leaves it.
    fn cells(&self, field: &Field, from: f64, to: f64, mut visit: impl FnMut(&[f32; 8], [i32; 3], f64, f64)) {
        let [low, high] = field.range().map(|end| DVec3::from_array(end.map(f64::from)));
        let Some((from, to)) = self.clipped(low, high, from, to) else { return };
        self.walk(SIDE as f64, from, to, |number, from, to| {
            let Some(block) = field.block(number) else { return };
            self.walk(1.0, from, to, |cell, from, to| {
                // At the ends of a block, rounding may give a cell of the neighbouring block.
                let place = [0, 1, 2].map(|axis| (cell[axis] - block.at[axis]).clamp(0, SIDE as i32 - 1) as usize);
                let corners = block.corners(place);
                if corners.iter().any(|corner| *corner > 0.0) {
                    visit(&corners, [0, 1, 2].map(|axis| block.at[axis] + place[axis] as i32), from, to);
                }
            });
        });
    }

    fn density(&self, corners: &[f32; 8], cell: [i32; 3], z: f64) -> f64 {
        trilinear(corners, (self.at(z) - DVec3::from_array(cell.map(f64::from))).to_array())
    }
}

/// Returns the optical depth of a volume from z `from` to z `to`.
pub(super) fn optical_depth(volume: &Volume, ray: &Ray, from: f64, to: f64) -> f64 {
    let way = FieldRay::of(ray, volume.placed());
    let mut sum = 0.0;
    way.cells(volume.field(), from, to, |corners, cell, from, to| {
        let (middle, reach) = (0.5 * (from + to), 0.5 * (to - from));
        // Two-point Gauss-Legendre quadrature: exact for polynomials of the third degree.
        let beside = reach / 3f64.sqrt();
        sum += reach * (way.density(corners, cell, middle - beside) + way.density(corners, cell, middle + beside));
    });
    sum * volume.placed().extinction * ray.direction.length()
}

/// Returns a volume's cells along a ray from z `from` onwards, in units of depth; `depth` converts z to depth.
pub(super) fn curve(volume: &Volume, ray: &Ray, from: f64, depth: impl Fn(f64) -> f64) -> Vec<Cubic> {
    let way = FieldRay::of(ray, volume.placed());
    let scale = volume.placed().extinction * ray.direction.length();
    let (mut cubics, mut before) = (Vec::new(), 0.0);
    way.cells(volume.field(), from, f64::INFINITY, |corners, cell, from, to| {
        let at = |share: f64| way.density(corners, cell, from + share * (to - from)) * scale * (to - from);
        let [a, b, c, d] = [at(0.0), at(1.0 / 3.0), at(2.0 / 3.0), at(1.0)];
        // The cubic through these four values.
        let powers = [
            a,
            -5.5 * a + 9.0 * b - 4.5 * c + d,
            9.0 * a - 22.5 * b + 18.0 * c - 4.5 * d,
            -4.5 * a + 13.5 * b - 13.5 * c + 4.5 * d,
        ];
        let cubic = Cubic { entry: depth(from), exit: depth(to), before, powers };
        before = cubic.optical_depth(cubic.exit);
        cubics.push(cubic);
    });
    cubics
}

/// Steps per cell in a picture. Twin: STEPS in glsl/shading/volume.glsl.
const STEPS: u32 = 2;

/// Visits the steps of a picture's march through a volume from z `from` to `to`, front to back, with the z of each step's midpoint and the
/// step's exact optical depth.
pub(super) fn steps(volume: &Volume, ray: &Ray, from: f64, to: f64, visit: impl FnMut(f64, f64)) {
    so_many_steps(STEPS, volume, ray, from, to, visit);
}

fn so_many_steps(count: u32, volume: &Volume, ray: &Ray, from: f64, to: f64, mut visit: impl FnMut(f64, f64)) {
    let way = FieldRay::of(ray, volume.placed());
    let scale = volume.placed().extinction * ray.direction.length();
    way.cells(volume.field(), from, to, |corners, cell, from, to| {
        let reach = 0.5 * (to - from) / f64::from(count);
        for i in 0..count {
            let (middle, beside) = (from + f64::from(2 * i + 1) * reach, reach / 3f64.sqrt());
            let density = |z: f64| way.density(corners, cell, z);
            visit(middle, scale * reach * (density(middle - beside) + density(middle + beside)));
        }
    });
}

/// Returns an approximate upper bound on the number of cells that a ray meets.
pub(super) fn tries(volume: &Volume) -> usize {
    let [low, high] = volume.field().range();
    (0..3).map(|axis| (high[axis] - low[axis]) as usize).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;
    use std::sync::Arc;

    fn volume(samples: Vec<([i32; 3], f32)>, placed: Placed) -> Volume {
        Volume::new(Arc::new(Field::new(samples).expect("a field")), placed).expect("a volume")
    }

    fn cube(count: i32, density: impl Fn([i32; 3]) -> f32) -> Vec<([i32; 3], f32)> {
        (0..count.pow(3))
            .map(|i| [i % count, i / count % count, i / count / count])
            .map(|place| (place, density(place)))
            .collect()
    }

    fn straight() -> Placed {
        Placed {
            origin: DVec3::new(1.0, -2.0, 0.5),
            steps: [0.5 * DVec3::X, 0.5 * DVec3::Y, 0.5 * DVec3::Z],
            extinction: 3.0,
            color: [1.0; 3],
            side: 1,
        }
    }

    /// In a field of constant density 2, a path 4 samples long has the optical depth 2 · 4 · ½ · 3 (density, samples, sample spacing,
    /// extinction) in any direction.
    #[test]
    fn constant_density() {
        let volume = volume(cube(20, |_| 2.0), straight());
        let middle = straight().origin + 0.5 * 9.5;
        for direction in [DVec3::X, -DVec3::Z, DVec3::new(1.0, -2.0, 0.5), DVec3::new(1.0, 1.0, 1.0)] {
            let ray = Ray { origin: middle, direction };
            let to = 2.0 / direction.length();
            let found = optical_depth(&volume, &ray, 0.0, to);
            assert!((found - 12.0).abs() < 1e-12, "{direction}: {found}");
            let both = optical_depth(&volume, &ray, -0.5 * to, 0.5 * to);
            assert!((both - 12.0).abs() < 1e-12, "{direction}: {both}");
        }
        assert_eq!(optical_depth(&volume, &Ray { origin: 100.0 * DVec3::X, direction: DVec3::Y }, -1e3, 1e3), 0.0);
    }

    /// A density of x has the mean (x₀ + x₁)/2 along any path from x₀ to x₁. A density of xyz is a cubic along the diagonal, with a known
    /// integral.
    #[test]
    fn ramps() {
        let ramp = volume(cube(24, |[x, ..]| x as f32), straight());
        let from = straight().origin + 0.5 * DVec3::new(3.2, 4.7, 5.1);
        for to in [DVec3::new(17.9, 6.3, 11.0), DVec3::new(3.2, 20.0, 5.1), DVec3::new(1.0, 2.0, 22.0)] {
            let direction = straight().origin + 0.5 * to - from;
            let found = optical_depth(&ramp, &Ray { origin: from, direction }, 0.0, 1.0);
            let expected = 3.0 * direction.length() * 0.5 * (3.2 + to.x);
            assert!((found - expected).abs() < 1e-10 * expected, "{to}: {found}, not {expected}");
        }
        let product = volume(cube(16, |[x, y, z]| (x * y * z) as f32), straight());
        let ray = Ray { origin: straight().origin, direction: DVec3::ONE };
        // ∫ t³ from 0 to 9 samples along the diagonal, on which one sample is √3 / 2 world units long; 3 is the extinction.
        let found = optical_depth(&product, &ray, 0.0, 4.5);
        let expected = 3.0 * 3f64.sqrt() * 0.5 * 9f64.powi(4) / 4.0;
        assert!((found - expected).abs() < 1e-10 * expected, "{found}, not {expected}");
    }

    /// A picture samples the light at the midpoint of each step. If light rises linearly along a ray, the picture's error is at most the
    /// change of light over half a step. It falls fast with more steps: the shorter a step, the nearer its midpoint is to the centroid of
    /// the light that it scatters.
    #[test]
    fn steps_of_a_picture() {
        let volume = volume(cube(20, |_| 0.25), straight());
        let origin = straight().origin + 0.5 * DVec3::new(1.3, 2.1, 1.7);
        let ray = Ray { origin, direction: DVec3::new(0.7, 0.6, 0.5) };
        let (end, rises) = (8.0, 0.25);
        let extinction = 0.25 * 3.0 * ray.direction.length();
        // ∫ (1 + r z) k e^(−k z) from 0 to the end.
        let left = (-extinction * end).exp();
        let exact = 1.0 - left + rises * ((1.0 - left) / extinction - end * left);
        let error = |count: u32| {
            let (mut sum, mut transmittance, mut longest) = (0.0, 1.0f64, 0.0f64);
            so_many_steps(count, &volume, &ray, 0.0, end, |middle, depth| {
                let passes = transmittance * (-depth).exp();
                sum += (transmittance - passes) * (1.0 + rises * middle);
                (transmittance, longest) = (passes, longest.max(depth / extinction));
            });
            assert!((transmittance / left - 1.0).abs() < 1e-9, "{transmittance}, not {left}");
            let off = f64::abs(sum - exact);
            assert!(off <= rises * 0.5 * longest, "{count}: {off}");
            off
        };
        let errors = [1, STEPS, 4 * STEPS].map(error);
        assert!(errors[1] < 0.4 * errors[0] && errors[2] < 0.1 * errors[1], "{errors:?}");
    }

    fn scattered() -> impl Strategy<Value = Vec<([i32; 3], f32)>> {
        let place = prop::array::uniform3(-6i32..14);
        prop::collection::vec((place, prop_oneof![Just(0.0f32), 0.0f32..4.0]), 1..60)
    }

    proptest! {
        /// Compares with a sum over small steps that reads the field without cells or blocks. The curve over depth gives the same integral.
        #[test]
        fn is_the_integral(
            samples in scattered(),
            from in prop::array::uniform3(-8.0f64..16.0),
            to in prop::array::uniform3(-8.0f64..16.0),
            turn in prop::array::uniform4(-1.0f64..1.0),
            straight_on in 0usize..6,
        ) {
            prop_assume!(turn.iter().map(|x| x * x).sum::<f64>() > 0.01);
            let turn = DQuat::from_array(turn).normalize();
            let steps = [0.5 * DVec3::X, 0.7 * DVec3::Y, 0.25 * DVec3::Z].map(|step| turn * step);
            let placed = Placed { origin: DVec3::new(0.3, 0.1, -0.2), steps, extinction: 0.7, color: [1.0; 3], side: 1 };
            let volume = volume(samples, placed);
            let mut to = to;
            // Half of the rays run along an axis, at integer coordinates.
            let mut from = from;
            if straight_on < 3 {
                from = from.map(f64::floor);
                to = std::array::from_fn(|i| if i == straight_on { to[i] } else { from[i] });
            }
            let world = |place: [f64; 3]| placed.origin + steps[0] * place[0] + steps[1] * place[1] + steps[2] * place[2];
            let ray = Ray { origin: world(from), direction: world(to) - world(from) };
            prop_assume!(ray.direction.length() > 0.05);
            let count = 6000;
            let density = |i: usize| {
                let share = (i as f64 + 0.5) / count as f64;
                volume.field().at(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])))
            };
            let upto = |end: usize| {
                (0..end).map(density).sum::<f64>() / count as f64 * 0.7 * ray.direction.length()
            };
            let expected = upto(count);
            let found = optical_depth(&volume, &ray, 0.0, 1.0);
            prop_assert!((found - expected).abs() < 2e-4 * (1.0 + expected), "{found}, not {expected}");
            let cells = curve(&volume, &ray, 0.0, |z| 2.0 * z - 0.5);
            prop_assert!(cells.windows(2).all(|pair| pair[0].exit <= pair[1].entry && pair[0].before <= pair[1].before));
            for end in [count / 3, count] {
                let depth = 2.0 * end as f64 / count as f64 - 0.5;
                let curve = super::super::true_curve::TrueCurve { volumes: vec![cells.clone()], ..Default::default() };
                let (found, exact) = (curve.optical_depth(depth), optical_depth(&volume, &ray, 0.0, end as f64 / count as f64));
                prop_assert!((found - exact).abs() < 1e-9 * (1.0 + exact), "{found}, not {exact}");
            }
        }
    }
}
