//! 16-bit floats, as images store them.

/// Converts IEEE 754 binary16 to f32. The conversion is exact: f32 can hold every half float.
pub(super) fn from_half(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    let (exponent, fraction) = (u32::from(bits >> 10 & 0x1f), u32::from(bits & 0x3ff));
    let magnitude = match exponent {
        // Subnormal: a multiple of 2⁻²⁴.
        0 => return f32::from_bits(sign | (fraction as f32 / 16_777_216.0).to_bits()),
        // Infinity, or NaN, which becomes a quiet NaN.
        31 if fraction == 0 => 0x7f80_0000,
        31 => 0x7fc0_0000 | (fraction << 13),
        // The exponent's bias is 15 in a half float and 127 in f32.
        _ => ((exponent + 112) << 23) | (fraction << 13),
    };
    f32::from_bits(sign | magnitude)
}

#[cfg(test)]
mod tests {
    #[test]
    fn all_of_them_are_as_another_crate_reads_them() {
        for bits in 0..=u16::MAX {
            let of_crate = half::f16::from_bits(bits).to_f32();
            assert_eq!(super::from_half(bits).to_bits(), of_crate.to_bits(), "{bits:#x}");
        }
    }
}
