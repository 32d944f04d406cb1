//! Baked files must be refused, or look-ups in them must stay in bounds: the look-up's CPU twin panics if it reads past its words.

use super::assert_one_line;
use super::memory::bounded;
use gobo::reference::twin::voxelized::Baked;
use gobo::technique::{TreeData, VoxelizedBake};

/// Number of voxels looked up in each tree.
const ASKED: u32 = 500;

/// Number of bytes in the checksum.
const LAST: usize = 4;

/// Opens the bytes as they are, and again with a corrected checksum, since hardly any mutated input has the right one.
pub fn bake(bytes: &[u8]) -> bool {
    let as_it_is = opened(bytes);
    let content = &bytes[..bytes.len().saturating_sub(LAST)];
    opened(&[content, &crc32fast::hash(content).to_le_bytes()].concat());
    as_it_is
}

fn opened(bytes: &[u8]) -> bool {
    let bake = match bounded(bytes.len(), || VoxelizedBake::read("input.gobo", bytes)) {
        Ok(bake) => bake,
        Err(error) => {
            assert_one_line(&error, "input.gobo");
            return false;
        }
    };
    let words: Vec<u32> = bake.words.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect();
    for tree in &bake.trees {
        let tree = twin(tree, if bake.plan.merges() { 16 } else { 32 }, &words);
        for number in 0..ASKED {
            // Corners first, then scattered voxels.
            let last = tree.size - 1;
            let strewn = |axis: u32| number.wrapping_mul(0x9E37_79B1).rotate_left(11 * axis + number) & last;
            let voxel = [0, 1, 2].map(|axis| if number < 8 { (number >> axis & 1) * last } else { strewn(axis) });
            tree.shadowed(voxel);
        }
    }
    assert_eq!(bake.bytes(), bytes, "what was read is what is written");
    true
}

fn twin(tree: &TreeData, header_bits: u32, words: &[u32]) -> Baked {
    let levels = tree.levels as usize;
    Baked {
        size: tree.size,
        root: tree.root,
        root_at: tree.root_at,
        at: tree.at[..levels].to_vec(),
        pointer_bits: tree.pointer_bits[..levels].to_vec(),
        header_bits,
        shortcuts: tree.shortcuts,
        words: words.to_vec(),
    }
}
