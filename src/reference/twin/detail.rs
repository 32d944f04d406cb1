//! CPU twin of glsl/maps/detail: a survey of the casters in each tile, and the choice of the tile's resolution.

use super::bins::{TILE_TEXELS, tile_distance};
use super::splat::strand_axis;
use crate::scene::{Caster, Projection, View};
use glam::{Vec2, Vec3};

/// Number of words per tile in the table. Twin: SLOTS.
pub const SLOTS: usize = 64;

/// Twin: SURVEY_CELLS.
const CELLS: u32 = 4;

/// Twins: LEAST_SCALE, MOST_SCALE.
const SCALES: [i32; 2] = [-760, 240];

/// Levels at which a tile gets one more block per side: 80 log2(1.5), 80 log2(2.5), …
const LEVELS: [i32; 7] = [47, 106, 145, 174, 197, 217, 233];

/// The survey of a tile. Twin: Survey.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tile {
    /// Bit 4 y + x is set if a caster meets cell (x, y).
    pub cells: u32,
    /// Sum over casters of the length of the caster's edge in the tile, times the share of light that it absorbs.
    pub edges: u32,
    /// Mean optical depth over the tile.
    pub optical_depth: u32,
}

/// Returns the view with `side` times as many texels per side. Twin: finer.
pub fn finer(view: &View, side: u32) -> View {
    View { width: view.width * side, height: view.height * side, ..*view }
}

/// Returns the corners of the caster's bounds in texels of a parallel view, enlarged by 1/16 of a texel. Twin: caster_bounds.
fn bounds(view: &View, caster: &Caster) -> [Vec2; 2] {
    let offset = Vec3::from(caster.position) - Vec3::from(view.origin);
    let place = |p: Vec3| {
        let across = Vec2::new(p.dot(Vec3::from(view.right)), p.dot(Vec3::from(view.up)));
        (across * Vec2::new(view.scale_x, view.scale_y) * 0.5 + 0.5) * Vec2::new(view.width as f32, view.height as f32)
    };
    let reach = Vec2::new(view.scale_x, view.scale_y).abs() * 0.5 * Vec2::new(view.width as f32, view.height as f32);
    let (start, end) = (place(offset), place(offset + strand_axis(caster)));
    let reach = reach * caster.radius + 0.0625;
    [start.min(end) - reach, start.max(end) + reach]
}

/// Returns, for one caster, the length of its edge within a tile, the share of light that it absorbs, and its mean optical depth over the
/// tile. Twin:
/// share_of_tile.
fn share_of_tile(view: &View, caster: &Caster) -> [f32; 3] {
    let texels = 0.5 * view.width as f32 * view.scale_x;
    let wide = 2.0 * caster.radius * texels;
    let (edge, area, optical_depth) = if caster.is_strand() {
        let (axis, forward) = (Vec3::from(caster.axis), Vec3::from(view.forward));
        let edge = (axis - axis.dot(forward) * forward).length() * texels;
        (edge, edge.min(8.0) * wide, caster.density)
    } else {
        (0.5 * wide, (wide * wide).min(64.0), caster.density * caster.radius * (4.0 / 3.0))
    };
    [edge.min(8.0), optical_depth / (1.0 + optical_depth), (area / 64.0 * optical_depth).min(1.0)]
}

/// Surveys a tile's casters in a parallel view. Cells are enlarged by `outset` texels, which is 1/16 in the twin,
/// glsl/maps/detail/survey.comp.
pub fn survey(view: &View, casters: &[Caster], tile: [u32; 2], outset: f32) -> Tile {
    assert_eq!(view.projection(), Projection::Parallel, "bounds in perspective have no twin");
    let fine = finer(view, CELLS);
    let mut known = Tile::default();
    for caster in casters {
        let [low, high] = bounds(&fine, caster);
        let mut cells = 0;
        for i in 0..CELLS * CELLS {
            let cell = [tile[0] * CELLS + i % CELLS, tile[1] * CELLS + i / CELLS];
            let corner = Vec2::new(cell[0] as f32, cell[1] as f32) * TILE_TEXELS as f32;
            let slack = outset - 0.0625;
            let apart = high.cmplt(corner - slack).any() || low.cmpge(corner + TILE_TEXELS as f32 + slack).any();
            let inside = corner.cmplt(Vec2::new(fine.width as f32, fine.height as f32)).all();
            if inside && !apart && tile_distance(&fine, caster, cell, -outset) <= 1.0001 {
                cells |= 1 << i;
            }
        }
        if cells != 0 {
            let [edge, taken, optical_depth] = share_of_tile(view, caster);
            known.cells |= cells;
            known.edges += (edge * taken * 16.0) as u32 + 1;
            known.optical_depth += (optical_depth * 1024.0 + 0.5) as u32;
        }
    }
    known
}

/// Twin: log_16.
fn log_16(x: u32) -> i32 {
    let top = x.ilog2();
    (16 * top + (x << (31 - top) >> 27 & 15)) as i32
}

/// Twin: tile_side.
fn tile_side(known: &Tile, tile: u32, across: u32, scale: i32) -> u32 {
    if known.cells == 0 {
        return 8;
    }
    let level = log_16(known.edges + 1) - log_16(1024 + known.optical_depth) + 160 + scale;
    let level = level + ((tile % across * 13 + tile / across * 29) & 31) as i32;
    1 + LEVELS.iter().filter(|least| level >= **least).count() as u32
}

/// Returns which of a tile's side × side blocks overlap cells with casters. Twin: row_cells, block_cells.
pub fn used_blocks(cells: u32, side: u32) -> Vec<bool> {
    let over = |cell: u32, block: u32| cell * side < (block + 1) * CELLS && (cell + 1) * side > block * CELLS;
    let used = |block: u32| {
        (0..CELLS * CELLS)
            .any(|i| cells >> i & 1 == 1 && over(i % CELLS, block % side) && over(i / CELLS, block / side))
    };
    (0..side * side).map(used).collect()
}

/// Returns the words of all tiles' tables, in rows of `across` tiles, with at most `block_count` blocks in total.
/// Twin: glsl/maps/detail/choose.comp.
pub fn choose(tiles: &[Tile], across: u32, block_count: usize) -> Vec<u32> {
    let counts: Vec<[usize; 9]> = (tiles.iter())
        .map(|known| {
            std::array::from_fn(|side| used_blocks(known.cells, side as u32).iter().filter(|used| **used).count())
        })
        .collect();
    let side = |tile: usize, scale| tile_side(&tiles[tile], tile as u32, across, scale);
    let count = |scale| (0..tiles.len()).map(|tile| counts[tile][side(tile, scale) as usize]).sum::<usize>();
    // All scales are tried, since a finer grid may need fewer blocks: its lines may miss a cell that the lines of a coarser grid cut.
    let [least, end] = SCALES;
    let scale = (least..end).rev().find(|scale| count(*scale) <= block_count).unwrap_or(least);
    let mut place = 0;
    let mut words = Vec::with_capacity(tiles.len() * SLOTS);
    for (tile, known) in tiles.iter().enumerate() {
        let side = side(tile, scale);
        let used = used_blocks(known.cells, side);
        for slot in 0..SLOTS {
            let is_used = used.get(slot).is_some_and(|used| *used);
            place += u32::from(is_used);
            words.push(side << 28 | if is_used { place } else { 0 });
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tiles() -> impl Strategy<Value = Vec<Tile>> {
        let number = || prop_oneof![0..100u32, any::<u32>().prop_map(|n| n >> 2), Just(0)];
        let tile = (prop_oneof![Just(0u32), 0..0x10000u32, Just(0xFFFF)], number(), number());
        let tile = tile.prop_map(|(cells, edges, optical_depth)| Tile { cells, edges, optical_depth });
        prop::collection::vec(tile, 1..80)
    }

    proptest! {
        /// There are never more blocks than allowed, no two share a place, and every cell with casters is covered by one.
        #[test]
        fn blocks_are_as_many_as_allowed(tiles in tiles(), across in 1..9u32, more in 0..3000usize) {
            let words = choose(&tiles, across, tiles.len() + more);
            let places: Vec<_> = words.iter().map(|w| w & 0xFFF_FFFF).filter(|place| *place > 0).collect();
            prop_assert!(places.len() <= tiles.len() + more);
            prop_assert!(places.iter().copied().eq(1..=places.len() as u32));
            for (tile, words) in tiles.iter().zip(words.chunks(SLOTS)) {
                let side = words[0] >> 28;
                prop_assert!((1..=8).contains(&side) && words.iter().all(|word| word >> 28 == side));
                // Centres of an 8 × 8 grid within each cell, in blocks.
                for i in 0..32 * 32 {
                    let [x, y] = [i % 32, i / 32];
                    let met = tile.cells >> (y / 8 * CELLS + x / 8) & 1 == 1;
                    let block = words[((2 * y + 1) * side / 64 * side + (2 * x + 1) * side / 64) as usize];
                    prop_assert!(!met || block & 0xFFF_FFFF > 0, "{tile:?}, side {side}, ({x}, {y})");
                }
            }
        }
    }
}
