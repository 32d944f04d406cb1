//! The totals that binning counts, and the parts of tiles that it lists.

use bytemuck::{Pod, Zeroable};

/// Twin: BinTotals in glsl/maps/bins/totals.glsl. Over all maps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BinTotals {
    /// Entries of all tiles, modulo 2³².
    pub entries: u32,
    /// How often `entries` has wrapped.
    pub entries_high: u32,
    /// Tiles with casters.
    pub tiles_used: u32,
    /// Parts of tiles that are built.
    pub parts: u32,
    /// x of a VkDispatchIndirectCommand with a workgroup per listed part.
    pub groups_x: u32,
    /// y of that command.
    pub groups_y: u32,
    /// z of that command.
    pub groups_z: u32,
    /// Not 0 where the driver ended loops over a tile's casters early.
    pub cut_short: u32,
    /// Casters of the tile that has the most.
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
    /// The map · 256 + the number of the part within the tile.
    pub map_part: u32,
    /// The index of the part's first entry.
    pub first: u32,
    /// The number of the part's entries, as far as there is room.
    pub count: u32,
}
