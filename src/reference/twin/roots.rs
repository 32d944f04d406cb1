//! CPU twin of glsl/technique/moments/roots.glsl: roots of polynomials whose roots are all real, in f32.

/// Number of steps of Laguerre's method per root. Twin: ROUNDS.
const ROUNDS: usize = 5;

/// Values closer to 0 than this count as 0. Twin: LEAST_ROOT.
const LEAST_ROOT: f32 = 1e-6;

/// Coefficients of u^(n−1), u^(n−2), …, at most 4 of them; the coefficient of u^n is 1.
pub type Factors = [f32; 4];

/// Returns the largest root of u^n + all\[0\] u^(n−1) + …, whose roots are at most 1 away from 0. Laguerre's method starts above the root
/// and never passes it. Twin: largest_root.
fn largest_root(all: &[f32]) -> f32 {
    let order = all.len() as f32;
    let spread = (all[0] * all[0] - 2.0 * order / (order - 1.0) * all[1]).max(0.0).sqrt();
    let mut u = -all[0] / order + (order - 1.0) / order * spread;
    for _ in 0..ROUNDS {
        let (mut value, mut slope, mut bend) = (1.0, 0.0, 0.0);
        for factor in all {
            bend = bend * u + slope;
            slope = slope * u + value;
            value = value * u + factor;
        }
        let under = (order - 1.0) * ((order - 1.0) * slope * slope - 2.0 * order * value * bend);
        let over = slope + under.max(0.0).sqrt();
        u -= if over > 0.0 { order * value / over } else { 0.0 };
    }
    u
}

/// Returns all roots of u^n + …, for n of at least 2. Roots far from 0 come first, so that deflation keeps the polynomial accurate near 0.
/// Twin:
/// real_roots.
pub fn real_roots(mut all: Factors, n: usize) -> Factors {
    let mut roots = [0.0; 4];
    for degree in (3..=n).rev() {
        // No root is farther from 0 than the square root of the sum of all roots' squares. If necessary, the polynomial is mirrored, so
        // that a root much farther from 0 than the others becomes the largest one.
        let square = all[0] * all[0];
        let bound = (square - 2.0 * all[1]).max(square / degree as f32).sqrt();
        if bound < LEAST_ROOT {
            break;
        }
        let unit = if all[0] > 0.0 { -bound } else { bound };
        let mut power = 1.0;
        for factor in &mut all[..degree] {
            power /= unit;
            *factor *= power;
        }
        let root = largest_root(&all[..degree]);
        roots[n - degree] = unit * root;
        // Deflation: divides the polynomial by (u − root), starting with the last coefficient.
        let mut carried = 0.0;
        for k in (1..degree).rev() {
            carried = if root > 0.0 { (carried - all[k]) / root } else { 0.0 };
            all[k] = carried;
        }
        power = 1.0;
        for k in 1..degree {
            power *= unit;
            all[k - 1] = all[k] * power;
        }
    }
    let half = -0.5 * all[0];
    let spread = (half * half - all[1]).max(0.0).sqrt();
    let far = if half < 0.0 { half - spread } else { half + spread };
    let near = if far.abs() > LEAST_ROOT { all[1] / far } else { 0.0 };
    (roots[n - 2], roots[n - 1]) = (far, near);
    roots
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Finds the roots of polynomials built from roots whose distances from 0 differ by up to a factor of a thousand.
        #[test]
        fn roots_are_found(mut roots in prop::collection::vec((-1.0..1.0f64, 0.0..3.0f64), 2..5)) {
            let mut roots: Vec<_> = roots.drain(..).map(|(unit, power)| unit * 10f64.powf(power)).collect();
            roots.sort_by(|a, b| b.total_cmp(a));
            let mut all = vec![1.0];
            for root in &roots {
                all.push(0.0);
                for i in (1..all.len()).rev() {
                    all[i] -= root * all[i - 1];
                }
            }
            let n = roots.len();
            let mut factors = [0.0; 4];
            factors.iter_mut().zip(&all[1..]).for_each(|(factor, exact)| *factor = *exact as f32);
            let found = real_roots(factors, n);
            // Compares values of the polynomial, not roots, since the rounding of coefficients may move close roots far.
            let most = roots.iter().fold(1f64, |most, root| most.max(root.abs()));
            for found in &found[..n] {
                let value = |u: f64| all.iter().fold(0.0, |value, factor| value * u + factor);
                let size = all.iter().fold(0.0, |size, factor| size * f64::from(*found).abs() + factor.abs());
                prop_assert!(value(f64::from(*found)).abs() < 1e-4 * size.max(most.powi(n as i32) * 1e-6), "{found:?} of {roots:?}");
            }
        }
    }
}
