//! Optical depth of an anisotropic Gaussian along a ray, in f64, tails included. Along a line a Gaussian is one-dimensional, so its optical
//! depth up to a point is an error function.

use crate::scene::{Caster, REACH, Ray, Shape};
use std::f64::consts::PI;

/// Standard deviations beyond which a Gaussian is ignored: its optical depth there is below exp(−12.5) = 4e-6 of the peak.
pub(super) const TRUE_REACH: f64 = 5.0;

/// A Gaussian along a ray, where it is one-dimensional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Along {
    /// z of the point on the ray that is nearest to the centre, measured in deviations.
    pub middle: f64,
    /// Deviation along the ray, in multiples of the ray's direction.
    pub deviation: f64,
    /// Squared distance of that point from the centre, in squared deviations.
    pub square: f64,
}

/// Returns whether the bounding sphere alone shows that a ray stays more than [`TRUE_REACH`] deviations from the centre.
pub(super) fn missed(ray: &Ray, caster: &Caster) -> bool {
    let offset = caster.start() - ray.origin;
    let square = ray.direction.length_squared();
    let radius = f64::from(caster.radius) * (TRUE_REACH / REACH);
    offset.length_squared() - offset.dot(ray.direction).powi(2) / square > 1.001 * radius * radius
}

/// Returns the Gaussian of a splat along a ray.
pub(crate) fn along(ray: &Ray, caster: &Caster) -> Along {
    let shape = Shape::of(caster);
    let (v, q) = (shape.whitened(ray.direction), shape.whitened(caster.start() - ray.origin));
    let square = v.length_squared();
    Along { middle: q.dot(v) / square, deviation: 1.0 / square.sqrt(), square: q.cross(v).length_squared() / square }
}

impl Along {
    /// Returns the z at which the ray enters and leaves the ellipsoid of `reach` deviations around the centre, or `None` if the ray misses
    /// it.
    pub fn within(&self, reach: f64) -> Option<(f64, f64)> {
        let half = (reach * reach - self.square).max(0.0).sqrt() * self.deviation;
        (half > 0.0).then_some((self.middle - half, self.middle + half))
    }

    /// Returns the optical depth from z `from` to z `to`.
    pub fn optical_depth(&self, ray: &Ray, caster: &Caster, from: f64, to: f64) -> f64 {
        let place = |z: f64| share((z - self.middle) / self.deviation);
        self.whole(ray, caster) * (place(to) - place(from)).max(0.0)
    }

    /// Returns the optical depth over the whole ray.
    pub fn whole(&self, ray: &Ray, caster: &Caster) -> f64 {
        let length = (2.0 * PI).sqrt() * self.deviation * ray.direction.length();
        f64::from(caster.density) * length * (-0.5 * self.square).exp()
    }
}

/// Returns the share of a Gaussian of deviation 1 that is below x, with an error of about 1e-15: by a series around 0, by Lentz's continued
/// fraction farther out.
pub(crate) fn share(x: f64) -> f64 {
    // Farther out, the tail is below the rounding error of 1 in f64.
    if x.abs() > 9.0 {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    let peak = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    if x.abs() < 3.0 {
        // Marsaglia 2004, Evaluating the Normal Distribution: x + x³/3 + x⁵/15 + …
        let (mut term, mut sum, mut i) = (x, x, 1.0);
        while sum + term != sum {
            i += 2.0;
            term *= x * x / i;
            sum += term;
        }
        return 0.5 + peak * sum;
    }
    let far = x.abs();
    let fraction = (1..=60).rev().fold(far, |below, k| far + f64::from(k) / below);
    let tail = peak / fraction;
    if x < 0.0 { tail } else { 1.0 - tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Shape, Splat};
    use glam::DVec3;
    use proptest::prelude::*;

    /// Expected values are from Abramowitz and Stegun, table 26.1; the one at 2.98 is from libm's `erfc`.
    #[test]
    fn shares_are_those_of_tables() {
        for (x, expected) in [
            (0.0, 0.5),
            (0.5, 0.691_462_461_274_013),
            (1.0, 0.841_344_746_068_543),
            (2.0, 0.977_249_868_051_821),
            (2.98, 0.998_558_758_082_660),
            (3.0, 0.998_650_101_968_370),
            (4.0, 0.999_968_328_758_167),
        ] {
            assert!((share(x) - expected).abs() < 2e-12, "{x}: {}", share(x));
            assert!((share(-x) - (1.0 - expected)).abs() < 2e-12, "{x}");
        }
    }

    proptest! {
        /// Compares with the extinction summed along the ray in small steps.
        #[test]
        fn is_the_integral(
            origin in prop::array::uniform3(-3.0f64..3.0),
            towards in prop::array::uniform3(-0.5f64..0.5),
            logs in prop::array::uniform3(-1.0f32..0.5),
            turn in prop::array::uniform4(-1.0f32..1.0),
            to in 0.0f64..2.0,
        ) {
            let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt();
            prop_assume!(length > 0.1);
            let splat = Splat {
                position: [0.1, -0.2, 0.3],
                deviations: logs.map(|log| 10f32.powf(log)),
                rotation: turn.map(|x| x / length),
                opacity: 0.7,
                color: [1.0; 3],
            };
            let caster = Caster::from(&splat);
            let ray = Ray { origin: origin.into(), direction: DVec3::from(towards) - DVec3::from(origin) };
            prop_assume!(ray.direction.length() > 0.1);
            let shape = Shape::of(&caster);
            let steps = 20_000;
            let step = to / f64::from(steps);
            let extinction = |z: f64| {
                let square = shape.whitened(ray.at(z) - caster.start()).length_squared();
                f64::from(caster.density) * (-0.5 * square).exp()
            };
            let sum: f64 = (0..steps).map(|i| extinction((f64::from(i) + 0.5) * step)).sum();
            let expected = sum * step * ray.direction.length();
            let found = along(&ray, &caster).optical_depth(&ray, &caster, 0.0, to);
            prop_assert!((found - expected).abs() < 1e-6 * (1.0 + expected), "{found} {expected}");
        }
    }
}
