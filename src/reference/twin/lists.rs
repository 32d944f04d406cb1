//! The triangles of each voxel. Twin of glsl/grid/lists/: the same words.

use super::grid::{Bits, Facet};
use std::collections::BTreeMap;

/// The bits of all levels, and the lists, of triangles whose corners are in voxels.
pub fn lists(triangles: impl Iterator<Item = [[f32; 3]; 3]>, size: u32) -> (Bits, Vec<u32>) {
    let mut bits = Bits::none(size);
    // By brick and bit; in the order of the triangles.
    let mut used: BTreeMap<(usize, u32), Vec<u32>> = BTreeMap::new();
    for (triangle, corners) in (0..).zip(triangles) {
        let facet = Facet::listed(corners, size);
        if facet.is_point() {
            continue;
        }
        for z in facet.first[2]..=facet.last[2] {
            for y in facet.first[1]..=facet.last[1] {
                for x in (facet.first[0]..=facet.last[0]).filter(|x| facet.meets([*x, y, z])) {
                    (0..3).for_each(|level| bits.set(level, [x, y, z]));
                    used.entry(bits.place(0, [x, y, z])).or_default().push(triangle);
                }
            }
        }
    }
    let bricks = (size / 4).pow(3);
    let mut words: Vec<u32> = Vec::new();
    let mut before = 0;
    for brick in 0..bricks as usize {
        words.push(bricks + before);
        before += bits.words[brick].count_ones();
    }
    let mut start = bricks + before + 1;
    words.push(start);
    for list in used.values() {
        start += list.len() as u32;
        words.push(start);
    }
    words.extend(used.into_values().flatten());
    (bits, words)
}
