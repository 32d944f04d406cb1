//! The totals that binning counts, and the parts of tiles that it lists.

use bytemuck::{Pod, Zeroable};

/// Totals over all maps. Twin: BinTotals in glsl/maps/bins/totals.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BinTotals {
    /// Number of entries over all tiles, modulo 2³².
    pub entries: u32,
    /// Number of times that `entries` has wrapped.
    pub entries_high: u32,
    /// Number of tiles with casters.
    pub tiles_used: u32,
    /// Number of parts of tiles to build.
    pub parts: u32,
    /// x of a VkDispatchIndirectCommand with one workgroup per listed part.
    pub groups_x: u32,
    /// y of that command.
    pub groups_y: u32,
    /// z of that command.
    pub groups_z: u32,
    /// Nonzero if the driver ended loops over a tile's casters early.
    pub cut_short: u32,
    /// Number of casters in the fullest tile.
    pub fullest: u32,
}

impl BinTotals {
    /// Returns the number of entries over all tiles.
    pub fn all_entries(&self) -> u64 {
        u64::from(self.entries_high) << 32 | u64::from(self.entries)
    }
}

/// The part of a tile that a workgroup builds. Twin: TilePart in glsl/maps/bins/totals.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TilePart {
    /// Index of the tile in its map, row by row.
    pub tile: u32,
    /// Index of the map · 256 + index of the part within the tile.
    pub map_part: u32,
    /// Index of the part's first entry.
    pub first: u32,
    /// Number of the part's entries that fit into the buffer.
    pub count: u32,
}
