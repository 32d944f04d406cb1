//! Voxelized shadows' twin: a tree or a graph over columns must agree with each voxel's column.

use gobo::reference::twin::voxelized::{Free, bake};

const SIZE: u32 = 64;

/// Reads bake settings from the first byte, then boxes of columns from six bytes each; later boxes overwrite earlier ones.
pub fn voxels(bytes: &[u8]) -> bool {
    let Some((code, rest)) = bytes.split_first() else { return false };
    let free = [Free::Exit, Free::Entry, Free::Shared][usize::from(code % 3)];
    let (merge, tile) = (code / 3 % 2 == 1, 8 << (code / 6 % 4));
    let mut columns = vec![[SIZE; 2]; (SIZE * SIZE) as usize];
    for b in rest.chunks_exact(6) {
        let [x, y, wide, high, entry, long] = [0, 1, 2, 3, 4, 5].map(|i| u32::from(b[i]));
        let entry = entry % (SIZE + 1);
        let column = [entry, (entry + long % (SIZE + 1)).min(SIZE)];
        for y in y % SIZE..(y % SIZE + high % SIZE + 1).min(SIZE) {
            for x in x % SIZE..(x % SIZE + wide % SIZE + 1).min(SIZE) {
                columns[(y * SIZE + x) as usize] = column;
            }
        }
    }
    let baked = bake(&columns, SIZE, tile, free, merge);
    for (i, [entry, exit]) in columns.iter().enumerate() {
        let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
        // Between entry and exit a voxel may have whichever value merges best.
        for z in [0, entry.wrapping_sub(1), *exit, exit + 1, SIZE - 1].into_iter().filter(|z| *z < SIZE) {
            let shadowed = baked.shadowed([x, y, z]).0;
            let is_free = z >= *entry && z < *exit;
            assert!(is_free || shadowed == (z >= *exit), "{x}, {y}, {z}: {shadowed}, of {entry} to {exit}");
        }
    }
    true
}
