//! CPU twin of glsl/maps/exact.glsl: reciprocals by Newton's method. It uses only products and sums, each rounded once, so that every
//! device gives the same bits.

use glam::Vec3;

/// Inputs of [`reciprocal`] are clamped to the range from here to [`MOST`].
const LEAST: f32 = 1e-36;
/// See [`LEAST`].
const MOST: f32 = 1e36;

/// Returns `1 / a` for a non-negative `a`.
pub fn reciprocal(a: f32) -> f32 {
    let of = a.clamp(LEAST, MOST);
    let mut guess = f32::from_bits(0x7ef3_11c7 - of.to_bits());
    for _ in 0..3 {
        guess *= 2.0 - of * guess;
    }
    guess
}

/// Returns the dot product, with sums in a fixed order.
pub fn dot3(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Returns an upper bound of a vector's length, at most a quarter too large.
pub fn longest3(a: Vec3) -> f32 {
    let along = a.abs();
    let most = along.x.max(along.y).max(along.z);
    most + 0.5 * (along.x + along.y + along.z - most)
}

/// Returns the cross product.
pub fn cross3(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The error bound of a reciprocal is two units in the last place, which the margin for rounding depths covers.
        #[test]
        fn inverses_are_as_near_as_a_devices(mantissa in 1.0f32..2.0, exponent in -110i32..110) {
            let a = mantissa * (exponent as f32).exp2();
            let one = f64::from(reciprocal(a)) * f64::from(a);
            prop_assert!((one - 1.0).abs() < 2.4e-7, "{a}: {one}");
        }

        #[test]
        fn longest_is_longer(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0) {
            let a = Vec3::new(x, y, z);
            let (exact, bound) = (a.as_dvec3().length(), f64::from(longest3(a)));
            prop_assert!(bound >= exact * (1.0 - 1e-6) && bound <= exact * 1.25, "{a}: {bound}, {exact}");
        }
    }
}
