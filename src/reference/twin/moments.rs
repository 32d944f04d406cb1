//! CPU twin of glsl/technique/moments/: what moments of a ray's optical depth say of it, in f32.

use super::harmonics::{cis, harmonics, turned};

/// Which functions are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Chebyshev polynomials up to the number of moments: they say what as many powers do, and round better.
    Power,
    /// Cosines and sines, half as many of each.
    Trigonometric,
}

/// The share of the circle that the range takes, so that its ends are apart on it. Twin: ZONE.
const ARC: f32 = 0.95;

/// The least pivot that is divided by. Twin: LEAST_PIVOT.
const LEAST_PIVOT: f32 = 1e-7;

/// Rounds of [`largest_root`]. Twin: ROUNDS.
const ROUNDS: usize = 5;

/// What a segment adds to each of the sums, 1 + `moments`: its optical depth, then that times the mean of each function. Places are
/// shares of the range. Twin: segment_parts.
pub fn parts([entry, exit]: [f32; 2], optical_depth: f32, basis: Basis, moments: u32) -> Vec<f32> {
    let mut parts = vec![optical_depth];
    match basis {
        Basis::Power => {
            let (p, q) = (2.0 * entry - 1.0, 2.0 * exit - 1.0);
            // Polynomials at p, and their divided differences from p to q.
            let (mut before, mut now) = (1.0, p);
            let (mut slope_before, mut slope) = (0.0, 1.0);
            for k in 1..=moments {
                let slope_after = 2.0 * (q * slope + now) - slope_before;
                let order = k as f32;
                let mean = slope_after / (order + 1.0) - if k > 1 { slope_before / (order - 1.0) } else { 0.0 };
                parts.push(optical_depth * 0.5 * mean);
                (before, now) = (now, 2.0 * p * now - before);
                (slope_before, slope) = (slope, slope_after);
            }
        }
        Basis::Trigonometric => harmonics(arc() * entry, arc() * exit, moments / 2, |mean| {
            parts.extend(mean.map(|mean| optical_depth * mean));
        }),
    }
    parts
}

fn arc() -> f32 {
    std::env::var("ARC").map_or(ARC, |a| a.parse().unwrap())
}

/// Square matrices and vectors of up to 5.
type Vector = [f32; 5];

/// What the moments are asked by.
struct Problem<'a> {
    basis: Basis,
    /// Means of the functions, the first of them 1.
    means: &'a [f32],
    /// Half as many as moments.
    degree: usize,
}

/// A place on the line or on the circle: x over y; half-angle's cosine and sine.
type Place = [f32; 2];

impl Problem<'_> {
    /// E of the k-th polynomial, or of cos and sin of k.
    fn mean(&self, k: usize) -> Place {
        match self.basis {
            Basis::Power => [self.means[k], 0.0],
            Basis::Trigonometric if k == 0 => [1.0, 0.0],
            Basis::Trigonometric => [self.means[2 * k - 1], self.means[2 * k]],
        }
    }

    /// The functions of half the order at a place, times its length to the power of the degree. Twin: half_functions.
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
                for i in 0..=self.degree {
                    let (order, part) = self.function(i);
                    if i > 0 && order != self.function(i - 1).0 {
                        at = turned(at, whole);
                    }
                    all[i] = at[part];
                }
            }
        }
        all
    }

    /// Of the circle: twice the order of function i, and whether it is a sine.
    fn function(&self, i: usize) -> (usize, usize) {
        match self.degree % 2 {
            1 => (1 + 2 * (i / 2), i % 2),
            _ => (2 * i.div_ceil(2), usize::from(i > 0 && i % 2 == 0)),
        }
    }

    /// E of the product of functions i and j of half the order. Twin: product_mean.
    fn product(&self, i: usize, j: usize) -> f32 {
        if self.basis == Basis::Power {
            return 0.5 * (self.means[i + j] + self.means[i.abs_diff(j)]);
        }
        let ((f, sine_i), (g, sine_j)) = (self.function(i), self.function(j));
        let (apart, together) = (self.mean(f.abs_diff(g) / 2), self.mean((f + g) / 2));
        match (sine_i, sine_j) {
            (0, 0) => 0.5 * (apart[0] + together[0]),
            (1, 1) => 0.5 * (apart[0] - together[0]),
            // The sine of a difference has its sign.
            _ => {
                let sine_order = if sine_i == 1 { f } else { g };
                let sign = if 2 * sine_order >= f + g { 1.0 } else { -1.0 };
                0.5 * (together[1] + sign * apart[1])
            }
        }
    }

    /// The lower triangle whose product with itself the matrix of means of products is. Twin: factored.
    fn factor(&self) -> [Vector; 5] {
        let mut lower = [[0.0; 5]; 5];
        for i in 0..=self.degree {
            for j in 0..=i {
                let mut rest = self.product(i, j);
                for k in 0..j {
                    rest -= lower[i][k] * lower[j][k];
                }
                lower[i][j] = if i == j { rest.max(LEAST_PIVOT).sqrt() } else { rest / lower[j][j] };
            }
        }
        lower
    }

    /// The inverse of the factor, times a vector. Twin: solved.
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

    /// The polynomial whose roots u are the other places of the quadrature that has one at `place`: those at distance 1 / u of it, on the
    /// circle at an angle whose half has u as its cotangent. Falling powers, the first of which has a factor above 0. Twin: around.
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
        // About the place, a cosine and a sine each: they turn the other way.
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

    /// What a place of the quadrature weighs. Twin: weight.
    fn weight(&self, lower: &[Vector; 5], place: Place) -> f32 {
        let square: f32 = self.solve(lower, self.functions(place)).iter().take(self.degree + 1).map(|y| y * y).sum();
        let length = match self.basis {
            Basis::Power => place[1].powi(2 * self.degree as i32),
            Basis::Trigonometric => 1.0,
        };
        length / square.max(LEAST_PIVOT)
    }
}

/// The largest root of a polynomial u^n + all\[0\] u^(n−1) + … whose roots are all real: Laguerre's method from above, which never
/// passes it. Twin: largest_root.
fn largest_root(all: &Vector, n: usize) -> f32 {
    let order = n as f32;
    let mean = -all[0] / order;
    let spread = (all[0] * all[0] - 2.0 * order / (order - 1.0) * all[1]).max(0.0).sqrt();
    let mut u = mean + (order - 1.0) / order * spread;
    for _ in 0..ROUNDS {
        u -= step(all, n, u);
    }
    u
}

/// How far Laguerre's step from above goes. Twin: laguerre_step.
fn step(all: &Vector, n: usize, u: f32) -> f32 {
    let (order, mut value, mut slope, mut bend) = (n as f32, 1.0, 0.0, 0.0);
    for factor in &all[..n] {
        bend = bend * u + slope;
        slope = slope * u + value;
        value = value * u + factor;
    }
    let under = (order - 1.0) * ((order - 1.0) * slope * slope - 2.0 * order * value * bend);
    let over = slope + under.max(0.0).sqrt();
    if over > 0.0 { order * value / over } else { 0.0 }
}

/// All real roots of u^n + …, the largest first. Twin: real_roots.
fn real_roots(mut all: Vector, n: usize) -> Vector {
    let mut roots = [0.0; 5];
    for (i, degree) in (3..=n).rev().enumerate() {
        let root = largest_root(&all, degree);
        roots[i] = root;
        // Divided by what has that root.
        let mut carried = 1.0;
        for factor in &mut all[..degree] {
            carried = carried * root + *factor;
            *factor = carried;
        }
    }
    let half = -0.5 * all[0];
    let spread = (half * half - all[1]).max(0.0).sqrt();
    let far = if half < 0.0 { half - spread } else { half + spread };
    let near = if far != 0.0 { all[1] / far } else { 0.0 };
    (roots[n - 2], roots[n - 1]) = (far.max(near), far.min(near));
    roots
}

/// The share of the optical depth that lies before a share of the range, 0 to 1: `overestimation` of what the sharpest bound
/// gives the place itself, all of what it puts before it. `means` are the sums over the first. Twin: moments_share.
pub fn share(means: &[f32], basis: Basis, overestimation: f32, at: f32) -> f32 {
    let problem = Problem { basis, means, degree: (means.len() - 1) / 2 };
    let n = problem.degree;
    let lower = problem.factor();
    let place = match basis {
        Basis::Power => [2.0 * at - 1.0, 1.0],
        Basis::Trigonometric => cis(0.5 * arc() * at),
    };
    let solved = problem.solve(&lower, problem.functions(place));
    let square: f32 = solved[..=n].iter().map(|y| y * y).sum();
    // The transposed factor's inverse.
    let mut c = solved;
    for i in (0..=n).rev() {
        for k in i + 1..=n {
            c[i] -= lower[k][i] * c[k];
        }
        c[i] /= lower[i][i];
    }
    let d = problem.around(&c, place);
    let mut monic = [0.0; 5];
    for i in 0..n {
        monic[i] = d[i + 1] / square;
    }
    let own = 1.0 / square;
    let (mut before, mut all) = (overestimation * own, own);
    for u in &real_roots(monic, n)[..n] {
        let long = u.abs().max(1.0);
        let (weight, is_before) = match basis {
            Basis::Power => (problem.weight(&lower, [(place[0] * u + 1.0) / long, u / long]), f32::from(*u < 0.0)),
            Basis::Trigonometric => {
                let length = (u * u + 1.0).sqrt();
                let there = turned(place, [u / length, 1.0 / length]);
                // From the place on, in circles. Between the range's end and its beginning it is both.
                let turns = 1.0f32.atan2(*u) / std::f32::consts::PI;
                let is_before = ((turns + arc() * at - arc()) / (1.0 - arc())).clamp(0.0, 1.0);
                (problem.weight(&lower, there), is_before)
            }
        };
        all += weight;
        before += weight * is_before;
    }
    before / all
}
