//! CPU twin of glsl/shading/painter: the list of casters of each tile of a picture, and the parts into which it is cut.

/// Pixels per side of a tile. Twin: PAINT_TILE.
pub const TILE: u32 = 8;

/// The casters that each tile of a picture of `size` pixels lists, in their `order`; tiles row by row. `boxes`: by caster, the first and the
/// last pixel that it may cover, in one word each: x in the lower 16 bits, y in the upper ones.
pub fn lists(size: [u32; 2], boxes: &[[u32; 2]], order: &[u32]) -> Vec<Vec<u32>> {
    let [across, down] = size.map(|side| side.div_ceil(TILE));
    let mut lists = vec![Vec::new(); (across * down) as usize];
    for caster in order {
        let [[left, top], [right, bottom]] = boxes[*caster as usize].map(|word| [word & 0xFFFF, word >> 16]);
        if left > right {
            continue;
        }
        for y in top / TILE..=bottom / TILE {
            for x in left / TILE..=right / TILE {
                lists[(y * across + x) as usize].push(*caster);
            }
        }
    }
    lists
}

/// How many parts a list of `entries` is cut into, where `all` tiles together have so many entries.
pub fn parts(entries: u32, all: u32, [least, most]: [u32; 2]) -> u32 {
    entries.div_ceil(least.max(all.div_ceil(most)))
}
