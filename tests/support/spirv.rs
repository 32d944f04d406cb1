//! SPIR-V for spirq.

use std::collections::BTreeSet;

/// The words with every OpSpecConstantOp (52) of logic or choice (166 to 169), of more or at least (172, 174)
/// or of a part of a vector (81), and those
/// computed from one, made an OpConstantNull (46) of the same type and id: spirq cannot compute
/// `EXPONENTIAL == 1u ? 0.0 : 1.0` and gives up. No block's layout depends on one.
pub fn without_constant_choices(words: &[u32]) -> Vec<u32> {
    let (header, mut rest) = words.split_at(5);
    let mut out = header.to_vec();
    let mut nulls = BTreeSet::new();
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        let made_null = || {
            [81, 166, 167, 168, 169, 172, 174].contains(&instruction[3])
                || instruction[4..].iter().any(|operand| nulls.contains(operand))
        };
        if first & 0xffff == 52 && made_null() {
            out.extend([3 << 16 | 46, instruction[1], instruction[2]]);
            nulls.insert(instruction[2]);
        } else {
            out.extend(instruction);
        }
        rest = after;
    }
    out
}
