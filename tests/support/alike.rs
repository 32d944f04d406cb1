//! Compares two results of the same look-ups: bit for bit if the technique promises that, otherwise within the rounding error of summing
//! the same numbers in two orders.

use gobo::technique::Spec;

/// Returns an error bound: how much two results of a look-up may differ if their optical depths τ are sums of the same numbers, up to
/// `terms` of them, in different orders. A result averages four values of e^−τ. The sums contribute 2 (n − 1) u τ (Higham 2002, section
/// 4.2; u = 2⁻²⁴) times e^−τ, and τ e^−τ ≤ 1 / e. Each e^−τ contributes 3 + 2 τ units of 2 u (the precision that Vulkan requires of exp),
/// relative to e^−τ, so most at τ = 0. Each sum and product of the average contributes u.
pub fn of_two_orders(terms: usize) -> f32 {
    const U: f32 = 1.0 / (1 << 24) as f32;
    let sums = 2.0 * terms as f32 / std::f32::consts::E;
    let (exponentials, average) = (2.0 * 3.0 * 2.0, 2.0 * 8.0);
    (sums + exponentials + average) * U
}

/// Asserts that `is` equals `expected` as closely as the spec's path promises, for this number of casters. The spec opens or names a single
/// path.
#[track_caller]
pub fn assert_alike(spec: &Spec, casters: usize, is: &[f32], expected: &[f32], what: &str) {
    assert_eq!(is.len(), expected.len(), "{what}");
    if spec.plans().iter().all(|plan| plan.promises.repeats) {
        let other = is.iter().zip(expected).position(|(is, expected)| is.to_bits() != expected.to_bits());
        assert!(other.is_none(), "{what}: another answer than {:?}", other.map(|i| (is[i], expected[i])));
        return;
    }
    let most = of_two_orders(casters);
    for (is, expected) in is.iter().zip(expected) {
        // Not `>`: a NaN must fail.
        assert!((is - expected).abs() <= most, "{what}: {is}, not {expected}, for {casters} casters");
    }
}
