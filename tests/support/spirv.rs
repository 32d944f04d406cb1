//! SPIR-V preprocessing for spirq.

use std::collections::BTreeSet;

/// Returns the words with some OpSpecConstantOps (52) replaced by an OpConstantNull (46) of the same type and id: logic and selection (166
/// to 169), comparison (172, 174), vector component extraction (81), and every operation on their results. spirq cannot evaluate
/// `EXPONENTIAL == 1u ? 0.0 : 1.0` and gives up. No block's layout depends on them.
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
