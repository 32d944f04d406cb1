//! Checks that look-ups stay within the words of a file. A pointer that leads outside may crash a device. A checksum detects damage, but
//! not a file that was written with wrong pointers.

use super::buffers::Shape;
use super::settings::Plan;
use super::{MAX_LEVELS, TreeData};

/// Kind of a child or root that has a node. Twin: INTERSECTED in glsl/technique/voxelized/tree.glsl.
const INTERSECTED: u64 = 3;

/// Returns whether every pointer of every tree leads to a node of the level below, and every cell at which look-ups start leads to a node
/// of the cells' level. `words` are the words of a file.
pub fn stays_inside(plan: &Plan, trees: &[TreeData], words: &[u8]) -> bool {
    let words = Words(words);
    let ends = trees.iter().skip(1).map(|next| u64::from(next.at[0])).chain([words.count()]);
    let of_light = |tree: &TreeData| tree.faces <= 6 && tree.first as usize + tree.faces as usize <= trees.len();
    trees.iter().zip(ends).all(|(tree, end)| of_light(tree) && tree_stays_inside(plan, tree, words, end).is_some())
}

/// Checks one tree: its levels are stored one after another, leaves first, followed by the cells at which look-ups start, up to word `end`.
fn tree_stays_inside(plan: &Plan, tree: &TreeData, words: Words, end: u64) -> Option<()> {
    let shape = Shape { size: plan.size, tile: plan.size };
    let levels = shape.root_level() as usize + 1;
    let cells = u64::from(tree.shortcuts)..end;
    let mut at = [cells.start; MAX_LEVELS + 1];
    at.iter_mut().zip(&tree.at[..levels]).for_each(|(at, word)| *at = u64::from(*word));
    let is_right = tree.size == plan.size
        && tree.levels as usize == levels
        && tree.pointer_bits[..levels].iter().all(|bits| *bits <= 32)
        && end <= words.count()
        && cells.start + u64::from(shape.shortcuts()) == end
        && at.is_sorted();
    if !is_right {
        return None;
    }
    let mut below = Nodes { leaves: (at[1] - at[0]) / 2, starts: Vec::new() };
    for level in 1..levels {
        let pointer_bits = u64::from(tree.pointer_bits[level]);
        below = nodes(words, at[level]..at[level + 1], u64::from(plan.header_bits()), pointer_bits, &below)?;
        if level == shape.shortcut_level() as usize {
            cells
                .clone()
                .all(|cell| words.bits(32 * cell, 32).is_some_and(|c| below.has_child(c & 3, c >> 2)))
                .then_some(())?;
        }
    }
    below.has_child(tree.root.into(), tree.root_at.into()).then_some(())
}

/// Returns the nodes of a level, or `None` if a pointer leads to something that is not a node of `below`.
fn nodes(words: Words, at: std::ops::Range<u64>, unit_bits: u64, pointer_bits: u64, below: &Nodes) -> Option<Nodes> {
    let units = (at.end - at.start) * 32 / unit_bits;
    let mut starts = vec![0u64; units as usize / 64 + 1];
    let mut unit = 0;
    while unit < units {
        let bit = 32 * at.start + unit_bits * unit;
        let mask = words.bits(bit, 16)?;
        // The last half word may be unused.
        if mask == 0 && unit + 1 == units {
            break;
        }
        let children = u64::from((mask & (mask >> 1) & 0x5555).count_ones());
        for child in 0..children {
            let pointer = words.bits(bit + unit_bits + child * pointer_bits, pointer_bits)?;
            below.has(pointer).then_some(())?;
        }
        starts[unit as usize / 64] |= 1 << (unit % 64);
        unit += 1 + (children * pointer_bits).div_ceil(unit_bits);
    }
    (unit <= units).then_some(Nodes { leaves: 0, starts })
}

/// Valid targets of pointers.
struct Nodes {
    /// Number of leaves: pointers hold a leaf's index.
    leaves: u64,
    /// Where other nodes begin, one bit per unit: pointers hold the first unit of a node.
    starts: Vec<u64>,
}

impl Nodes {
    /// Returns whether this kind of child exists and, if such a child has a node, `pointer` leads to one.
    fn has_child(&self, kind: u64, pointer: u64) -> bool {
        (1..=INTERSECTED).contains(&kind) && (kind != INTERSECTED || self.has(pointer))
    }

    fn has(&self, pointer: u64) -> bool {
        pointer < self.leaves || self.starts.get(pointer as usize / 64).is_some_and(|s| s >> (pointer % 64) & 1 == 1)
    }
}

/// Little-endian words.
#[derive(Clone, Copy)]
struct Words<'a>(&'a [u8]);

impl Words<'_> {
    fn count(self) -> u64 {
        self.0.len() as u64 / 4
    }

    /// Returns `count` bits, at most 32, from bit `bit` on; `None` past the end.
    fn bits(self, bit: u64, count: u64) -> Option<u64> {
        let word = |at: u64| {
            let at = 4 * at as usize;
            self.0.get(at..at + 4).map(|bytes| u64::from(bytemuck::pod_read_unaligned::<u32>(bytes)))
        };
        let (at, shift) = (bit / 32, bit % 32);
        let high = if shift + count > 32 { word(at + 1)? } else { 0 };
        Some((word(at)? | high << 32) >> shift & ((1 << count) - 1))
    }
}
