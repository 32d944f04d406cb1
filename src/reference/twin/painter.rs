//! CPU twin of glsl/shading/painter: the list of casters in each tile of a picture, and the parts into which it is split.

/// Number of pixels per side of a tile. Twin: PAINT_TILE.
pub const TILE: u32 = 8;

/// Returns the casters listed by each tile of a picture of `size` pixels, in their `order`, with the tiles in rows. `boxes` holds, for each
/// caster, the first and the last pixel that it may cover, in one word each: x in the lower 16 bits, y in the upper ones.
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

/// Returns the number of parts into which a list of `entries` entries is split, if all tiles together have `all` entries.
pub fn parts(entries: u32, all: u32, [least, most]: [u32; 2]) -> u32 {
    entries.div_ceil(least.max(all.div_ceil(most)))
}
