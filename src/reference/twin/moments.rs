//! CPU twin of glsl/technique/moments/: bounds of a ray's optical depth from its moments, in f32.

use super::harmonics::{cis, harmonics, turned};
use super::roots::real_roots;

/// The functions that are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Chebyshev polynomials up to the number of moments: they hold the same information as powers, with less rounding.
    Power,
    /// Cosines and sines, half as many of each.
    Trigonometric,
}

/// Share of the circle onto which the range is mapped, so that the ends of the range do not meet. Twin: ARC.
const ARC: f32 = 0.65;

/// Squared difference of directions below which two positions count as one. Twin: SAME.
const SAME: f32 = 1e-6;

/// Below this optical depth, moments are mostly rounding, so the optical depth is spread evenly over the range. Twin: THIN.
const THIN: f32 = 2e-3;

/// Returns the share by which moments are moved towards the moments of a spread-out distribution, which are 0. Despite rounding, they then
/// remain moments of some distribution. Twin: BIAS.
pub fn bias(moments: usize, in_16_bits: bool) -> f32 {
    if moments == 8 || in_16_bits { 3e-4 } else { 3e-5 }
}

/// Smaller pivots are replaced by this before a division. Twin: LEAST_PIVOT.
const LEAST_PIVOT: f32 = 1e-5;

/// Returns what a segment between two positions in the range adds to each sum. To the first sum it adds its optical depth; to each further
/// sum, its optical depth times the function's mean over the segment. Twin: segment_parts.
pub fn parts<const N: usize>(basis: Basis, [entry, exit]: [f32; 2], optical_depth: f32) -> [f32; N] {
    let mut parts = [optical_depth; N];
    match basis {
        Basis::Power => {
            let (p, q) = (2.0 * entry - 1.0, 2.0 * exit - 1.0);
            // Polynomials at p, and their divided differences from p to q.
            let (mut before, mut now) = (1.0, p);
            let (mut slope_before, mut slope) = (0.0, 1.0);
            for (k, part) in (1..).zip(&mut parts[1..]) {
                let slope_after = 2.0 * (q * slope + now) - slope_before;
                let order = k as f32;
                let mean = slope_after / (order + 1.0) - if k > 1 { slope_before / (order - 1.0) } else { 0.0 };
                *part = optical_depth * 0.5 * mean;
                (before, now) = (now, 2.0 * p * now - before);
                (slope_before, slope) = (slope, slope_after);
            }
        }
        Basis::Trigonometric => {
            let pairs = parts[1..].as_chunks_mut::<2>().0;
            for (pair, mean) in pairs.iter_mut().zip(harmonics(ARC * entry, ARC * exit)) {
                *pair = mean.map(|mean| optical_depth * mean);
            }
        }
    }
    parts
}

/// A vector, or a row of a square matrix, of up to 5 numbers.
type Vector = [f32; 5];

/// The moments of one look-up.
struct Problem<'a> {
    basis: Basis,
    /// Means of the functions, the first of which is 1.
    means: &'a [f32],
    /// Half the number of moments.
    degree: usize,
}

/// A position: on the line, x over y; on the circle, the cosine and sine of half its angle.
type Place = [f32; 2];

impl Problem<'_> {
    /// Returns the mean of the Chebyshev polynomial of degree k for powers, or the means of the cosine and sine of order k.
    fn mean(&self, k: usize) -> Place {
        match self.basis {
            Basis::Power => [self.means[k], 0.0],
            Basis::Trigonometric if k == 0 => [1.0, 0.0],
            Basis::Trigonometric => [self.means[2 * k - 1], self.means[2 * k]],
        }
    }

    /// Returns the basis functions at a position, from degree 0 up to half the order. For powers, these are Chebyshev polynomials, each
    /// multiplied by y to the power of `degree`, which keeps them finite. Twin: half_functions.
    fn functions(&self, [x, y]: Place) -> Vector {
        let mut all = [0.0; 5];
        match self.basis {
            Basis::Power => {
                let mut scale = 1.0;
                all[0] = 1.0;
                all[1] = x;
                for i in 2..=self.degree {
                    all[i] = 2.0 * x * all[i - 1] - y * y * all[i - 2];
                }
                for i in (0..=self.degree).rev() {
                    all[i] *= scale;
                    scale *= y;
                }
            }
            Basis::Trigonometric => {
                let half = [x, y];
                let whole = turned(half, half);
                let mut at = if self.degree % 2 == 1 { half } else { [1.0, 0.0] };
                for (i, value) in all.iter_mut().enumerate().take(self.degree + 1) {
                    let (order, part) = self.function(i);
                    if i > 0 && order != self.function(i - 1).0 {
                        at = turned(at, whole);
                    }
                    *value = at[part];
                }
            }
        }
        all
    }

    /// Returns, for function i on the circle, twice its order, and 1 if it is a sine, otherwise 0.
    fn function(&self, i: usize) -> (usize, usize) {
        match self.degree % 2 {
            1 => (1 + 2 * (i / 2), i % 2),
            _ => (2 * i.div_ceil(2), usize::from(i > 0 && i.is_multiple_of(2))),
        }
    }

    /// Returns the mean of the product of functions i and j of half the order. Twin: product_mean.
    fn product(&self, i: usize, j: usize) -> f32 {
        if self.basis == Basis::Power {
            return 0.5 * (self.means[i + j] + self.means[i.abs_diff(j)]);
        }
        let ((f, sine_i), (g, sine_j)) = (self.function(i), self.function(j));
        let (apart, together) = (self.mean(f.abs_diff(g) / 2), self.mean((f + g) / 2));
        match (sine_i, sine_j) {
            (0, 0) => 0.5 * (apart[0] + together[0]),
            (1, 1) => 0.5 * (apart[0] - together[0]),
            // The sine of a difference changes sign with the difference.
            _ => {
                let sine_order = if sine_i == 1 { f } else { g };
                let sign = if 2 * sine_order >= f + g { 1.0 } else { -1.0 };
                0.5 * (together[1] + sign * apart[1])
            }
        }
    }

    /// Returns the Cholesky factor of the matrix of means of products. Twin: factored.
    fn factor(&self) -> [Vector; 5] {
        let mut lower = [[0.0; 5]; 5];
        for i in 0..=self.degree {
            for j in 0..=i {
                let mut rest = self.product(i, j);
                for (a, b) in lower[i].iter().zip(&lower[j]).take(j) {
                    rest -= a * b;
                }
                lower[i][j] = if i == j { rest.max(LEAST_PIVOT).sqrt() } else { rest / lower[j][j] };
            }
        }
        lower
    }

    /// Multiplies a vector by the inverse of the factor. Twin: solved.
    fn solve(&self, lower: &[Vector; 5], right: Vector) -> Vector {
        let mut all = right;
        for i in 0..=self.degree {
            for k in 0..i {
                all[i] -= lower[i][k] * all[k];
            }
            all[i] /= lower[i][i];
        }
        all
    }

    /// Returns a polynomial whose roots u give the other points of the quadrature that has one point at `place`. For powers, the range is a
    /// line, and a root u gives the point at distance 1 / u from `place`. For cosines and sines it is a circle, and the angle between the
    /// two points is twice the arc cotangent of u. Twin: around.
    fn around(&self, c: &Vector, place: Place) -> Vector {
        let n = self.degree;
        if self.basis == Basis::Power {
            let x = place[0];
            let s = x * x;
            let mut d = [c[0] + c[1] * x + c[2] * (2.0 * s - 1.0), c[1] + c[2] * 4.0 * x, 2.0 * c[2], 0.0, 0.0];
            if n >= 3 {
                d[0] += c[3] * x * (4.0 * s - 3.0);
                d[1] += c[3] * (12.0 * s - 3.0);
                d[2] += c[3] * 12.0 * x;
                d[3] += c[3] * 4.0;
            }
            if n >= 4 {
                d[0] += c[4] * (8.0 * s * (s - 1.0) + 1.0);
                d[1] += c[4] * x * (32.0 * s - 16.0);
                d[2] += c[4] * (48.0 * s - 8.0);
                d[3] += c[4] * 32.0 * x;
                d[4] += c[4] * 8.0;
            }
            return d;
        }
        let whole = turned(place, place);
        // Rotates the factors of a cosine and a sine, so that angles are measured from `place`.
        let about = |a: f32, b: f32, [cos, sin]: Place| [a * cos + b * sin, b * cos - a * sin];
        match n {
            2 => {
                let [a, b] = about(c[1], c[2], whole);
                [c[0] + a, 2.0 * b, c[0] - a, 0.0, 0.0]
            }
            3 => {
                let ([a, b], [d, e]) = (about(c[0], c[1], place), about(c[2], c[3], turned(whole, place)));
                [a + d, b + 3.0 * e, a - 3.0 * d, b - e, 0.0]
            }
            _ => {
                let ([a, b], [d, e]) = (about(c[1], c[2], whole), about(c[3], c[4], turned(whole, whole)));
                [c[0] + a + d, 2.0 * b + 4.0 * e, 2.0 * c[0] - 6.0 * d, 2.0 * b - 4.0 * e, c[0] - a + d]
            }
        }
    }
}

/// Returns the optical depth up to a position in the range, from sums before the bias. `bias` is the value of [`bias`].
/// Twin: texel_transmittance.
pub fn optical_depth(sums: &[f32], basis: Basis, overestimation: f32, bias: f32, place: f32) -> f32 {
    let total = sums[0];
    if place <= 0.0 || place >= 1.0 {
        return if place <= 0.0 { 0.0 } else { total };
    }
    if total < THIN {
        return total * place;
    }
    let mut means: Vec<_> = sums.iter().map(|sum| (1.0 - bias) * (sum / total)).collect();
    means[0] = 1.0;
    total * share(&means, basis, overestimation, place)
}

/// Returns the sums after storage in 16 bits each; the first keeps its 32 bits. Twin: store_sums.
pub fn kept<const N: usize>(mut sums: [f32; N]) -> [f32; N] {
    let total = sums[0];
    for sum in &mut sums[1..] {
        let mean = if total > 0.0 { *sum / total } else { 0.0 };
        *sum = total * (mean.clamp(-1.0, 1.0) * 32767.0).round() / 32767.0;
    }
    sums
}

/// Returns the share of the optical depth in front of a position in the range: the sharpest lower bound of that share, plus
/// `overestimation` times the weight that the quadrature gives to the position itself. `means` are the sums divided by the first. Twin:
/// moments_share.
fn share(means: &[f32], basis: Basis, overestimation: f32, at: f32) -> f32 {
    let problem = Problem { basis, means, degree: (means.len() - 1) / 2 };
    let n = problem.degree;
    let lower = problem.factor();
    let place = match basis {
        Basis::Power => [2.0 * at - 1.0, 1.0],
        Basis::Trigonometric => cis(0.5 * ARC * at),
    };
    let solved = problem.solve(&lower, problem.functions(place));
    let square = square_of(&solved).max(LEAST_PIVOT);
    // The transposed factor's inverse.
    let mut c = solved;
    for i in (0..=n).rev() {
        for k in i + 1..=n {
            c[i] -= lower[k][i] * c[k];
        }
        c[i] /= lower[i][i];
    }
    let d = problem.around(&c, place);
    let mut monic = [0.0; 4];
    for i in 0..n {
        monic[i] = d[i + 1] / square;
    }
    // The functions' vectors at the quadrature's points are orthogonal. If rounding splits one point into two, they share its weight.
    let mut seen = [([0.0; 5], 0.0); 5];
    seen[0] = (solved.map(|y| y / square.sqrt()), 1.0 / square.sqrt());
    let (mut before, mut all) = (overestimation / square, 1.0 / square);
    for (i, u) in real_roots(monic, n)[..n].iter().enumerate() {
        let (there, one, is_before) = match basis {
            Basis::Power => {
                let long = u.abs().max(1.0);
                let y = u / long;
                ([(place[0] * u + 1.0) / long, y], y.powi(n as i32), f32::from(*u < 0.0))
            }
            Basis::Trigonometric => {
                let length = (u * u + 1.0).sqrt();
                // The angle from the position, in circles. In the gap between the end of the range and its start, a position counts partly
                // as before.
                let turns = 1.0f32.atan2(*u) / std::f32::consts::PI;
                let is_before = ((turns + ARC * at - ARC) / (1.0 - ARC)).clamp(0.0, 1.0);
                (turned(place, [u / length, 1.0 / length]), 1.0, is_before)
            }
        };
        let (mut rest, mut one) = (problem.solve(&lower, problem.functions(there)), one);
        let least = SAME * square_of(&rest);
        for (direction, value) in &seen[..=i] {
            let along: f32 = rest.iter().zip(direction).map(|(a, b)| a * b).sum();
            rest.iter_mut().zip(direction).for_each(|(rest, d)| *rest -= along * d);
            one -= along * value;
        }
        let square = square_of(&rest);
        if square > least {
            seen[i + 1] = (rest.map(|r| r / square.sqrt()), one / square.sqrt());
            let weight = one * one / square;
            all += weight;
            before += weight * is_before;
        }
    }
    before / all
}

fn square_of(all: &Vector) -> f32 {
    all.iter().map(|y| y * y).sum()
}

#[cfg(test)]
mod tests {
    use super::super::sum_checks::{casters, invariants, slab_error};
    use super::*;
    use proptest::prelude::*;

    const BASES: [Basis; 2] = [Basis::Power, Basis::Trigonometric];

    /// Moments agree with numerical integrals in f64.
    #[test]
    fn parts_are_integrals() {
        for (entry, exit) in [(0.0f32, 1.0f32), (0.1, 0.15), (0.5, 0.5), (0.93, 0.9301), (0.999, 1.0)] {
            for basis in BASES {
                let found: [f32; 9] = parts(basis, [entry, exit], 3.0);
                for (k, found) in found.into_iter().enumerate() {
                    let function = |z: f64| match basis {
                        Basis::Power => (k as f64 * (2.0 * z - 1.0).clamp(-1.0, 1.0).acos()).cos(),
                        Basis::Trigonometric => {
                            let angle = std::f64::consts::TAU * f64::from(ARC) * z * k.div_ceil(2) as f64;
                            if k > 0 && k % 2 == 0 { angle.sin() } else { angle.cos() }
                        }
                    };
                    let cut = |i: u32| f64::from(entry) + f64::from(exit - entry) * (f64::from(i) + 0.5) / 2000.0;
                    let exact = 3.0 * (0..2000).map(|i| function(cut(i))).sum::<f64>() / 2000.0;
                    assert!(
                        (f64::from(found) - exact).abs() < 2e-5,
                        "{basis:?} {k} {entry} {exit}: {found}, not {exact}"
                    );
                }
            }
        }
    }

    /// If all optical depth is at a few positions, moments determine the curve: the bounds coincide everywhere except at these positions.
    #[test]
    fn few_places_are_found() {
        let places = [(0.2f32, 1.0f32), (0.7, 0.5)];
        for basis in BASES {
            let mut sums = [0.0; 7];
            for (place, optical_depth) in places {
                let of: [f32; 7] = parts(basis, [place, place], optical_depth);
                sums.iter_mut().zip(of).for_each(|(sum, part)| *sum += part);
            }
            for at in [0.05f32, 0.12, 0.3, 0.45, 0.6, 0.8, 0.95] {
                let exact: f32 = places.iter().filter(|(place, _)| *place < at).map(|(_, t)| t).sum();
                for overestimation in [0.0, 1.0] {
                    let found = optical_depth(&sums, basis, overestimation, 1e-5, at);
                    assert!((found - exact).abs() < 0.03, "{basis:?} {at} {overestimation}: {found}, not {exact}");
                }
            }
        }
    }

    /// The optical depth of a slab lies between the bounds, and more moments tighten them.
    #[test]
    fn a_slab() {
        let of = |overestimation| {
            let depth = move |sums: &[f32], at| optical_depth(sums, Basis::Power, overestimation, 1e-5, at);
            [
                slab_error([0.3, 0.7], |place, t| parts::<5>(Basis::Power, place, t), |sums, at| depth(sums, at)),
                slab_error([0.3, 0.7], |place, t| parts::<9>(Basis::Power, place, t), |sums, at| depth(sums, at)),
            ]
        };
        let (middle, least) = (of(0.5), of(0.0));
        assert!(middle[0] < 0.01 && middle[1] < middle[0] && least[1] < least[0], "{middle:?}, {least:?}");
        assert!(least[0] > 4.0 * middle[0], "what ships is too light: {middle:?}, {least:?}");
    }

    proptest! {
        /// With powers, transmittance never rises; on the circle it may, since light may wrap around.
        #[test]
        fn stay_within_bounds(all in casters(), overestimation in prop_oneof![Just(0.0f32), Just(0.4), Just(1.0)]) {
            for (basis, rise) in [(Basis::Power, 1e-4), (Basis::Trigonometric, 1.0)] {
                let depth = |bias: f32| move |sums: &[f32], at| optical_depth(sums, basis, overestimation, bias, at);
                invariants::<5>(&all, |place, t| parts(basis, place, t), |sums| sums, |s, at| depth(bias(s.len() - 1, false))(s, at), rise)?;
                invariants::<7>(&all, |place, t| parts(basis, place, t), |sums| sums, |s, at| depth(bias(s.len() - 1, false))(s, at), rise)?;
                invariants::<9>(&all, |place, t| parts(basis, place, t), |sums| sums, |s, at| depth(bias(s.len() - 1, false))(s, at), rise)?;
                invariants::<9>(&all, |place, t| parts(basis, place, t), kept, |s, at| depth(bias(s.len() - 1, true))(s, at), rise)?;
            }
        }
    }
}
