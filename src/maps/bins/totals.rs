//! What binning counts, and the parts of tiles that it lists.

use bytemuck::{Pod, Zeroable};

/// Twin: BinTotals in glsl/maps/bins/totals.glsl. Over all maps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BinTotals {
    /// Entries of all tiles, modulo 2³².
    pub entries: u32,
    /// How often they have passed that.
    pub entries_high: u32,
    /// Tiles with casters.
    pub tiles_used: u32,
    /// Parts of tiles that are built.
    pub parts: u32,
    /// VkDispatchIndirectCommand of a workgroup a listed part.
    pub groups_x: u32,
    /// Likewise.
    pub groups_y: u32,
    /// Likewise.
    pub groups_z: u32,
    /// Not 0: the driver ended loops over a tile's casters before their time.
    pub cut_short: u32,
    /// Most casters of a tile.
    pub fullest: u32,
}

impl BinTotals {
    /// Entries of all tiles.
    pub fn all_entries(&self) -> u64 {
        u64::from(self.entries_high) << 32 | u64::from(self.entries)
    }
}

/// The part of a tile that a workgroup builds. Twin: TilePart in glsl/maps/bins/totals.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TilePart {
    /// The tile's place in its map, row after row.
    pub tile: u32,
    /// Which of the maps · 256 + which part of the tile.
    pub map_part: u32,
    /// The first of the tile's entries.
    pub first: u32,
    /// How many of them there are, as far as there is room.
    pub count: u32,
}
