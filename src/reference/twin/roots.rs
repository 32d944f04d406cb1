//! CPU twin of glsl/technique/moments/roots.glsl: roots of polynomials that have real ones only, in f32.

/// Rounds of [`largest_root`]. Twin: ROUNDS.
const ROUNDS: usize = 5;

/// Factors of u^(n−1) and on, of which there are up to 4.
type Factors = [f32; 5];

/// The largest root of a polynomial u^n + all\[0\] u^(n−1) + … whose roots are all real: Laguerre's method from above, which never
/// passes it. Twin: largest_root.
fn largest_root(all: &Factors, n: usize) -> f32 {
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
fn step(all: &Factors, n: usize, u: f32) -> f32 {
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
pub fn real_roots(mut all: Factors, n: usize) -> Factors {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Of polynomials made from roots that are up to a thousand times as far from 0 as one another.
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
            let mut factors = [0.0; 5];
            factors.iter_mut().zip(&all[1..]).for_each(|(factor, exact)| *factor = *exact as f32);
            let found = real_roots(factors, n);
            // What the rounded factors' roots may be off: roots that lie close are moved by the root of a rounding.
            let most = roots.iter().fold(1f64, |most, root| most.max(root.abs()));
            for found in &found[..n] {
                let value = |u: f64| all.iter().fold(0.0, |value, factor| value * u + factor);
                let size = all.iter().fold(0.0, |size, factor| size * f64::from(*found).abs() + factor.abs());
                prop_assert!(value(f64::from(*found)).abs() < 1e-4 * size.max(most.powi(n as i32) * 1e-6), "{found:?} of {roots:?}");
            }
        }
    }
}
