//! Whether two answers to the same question are the same: to the bit where the technique promises that, else as the same numbers summed in
//! two orders are.

use gobo::technique::Spec;

/// By how much e^−τ may differ where τ is the same up to `terms` numbers summed in two orders, τ is made a transmittance, and four of those
/// are averaged. 2 (n − 1) u τ of the sums (Higham 2002, section 4.2; u = 2⁻²⁴), times e^−τ, of which τ e^−τ ≤ 1 / e; 3 + 2 τ units of
/// 2 u of each e^−τ (the precision that Vulkan asks of exp), which is most at τ = 0; u of each sum and product of the average.
pub fn of_two_orders(terms: usize) -> f32 {
    const U: f32 = 1.0 / (1 << 24) as f32;
    let sums = 2.0 * terms as f32 / std::f32::consts::E;
    let (exponentials, average) = (2.0 * 3.0 * 2.0, 2.0 * 8.0);
    (sums + exponentials + average) * U
}

/// Fails where `is` is another answer than `expected`, both of the only path that a spec opens or names, for so many casters.
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
        // Not "more than": a NaN is no answer.
        assert!((is - expected).abs() <= most, "{what}: {is}, not {expected}, for {casters} casters");
    }
}
