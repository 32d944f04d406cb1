//! How techniques use bins.

/// Data kept per caster of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// Nothing: the technique only needs to know which casters and tiles meet.
    None,
    /// The caster, with the depth to sort by.
    Sorted,
    /// The caster, with the maximum optical depth that it adds to any ray: for sums in any order.
    Summed,
}

/// How a technique uses bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use {
    /// Data kept about each tile's casters.
    pub entries: Entries,
    /// Whether casters in the shadow of meshes may be skipped.
    pub skip: bool,
    /// Distance from a tile, in texels, within which look-ups read the tile.
    pub reach: u32,
    /// Workgroups per tile in [`crate::maps::Bins::per_part`]: for a tile with casters, and for one without.
    pub parts: [u32; 2],
    /// Whether a texel represents its whole square, rather than only the ray through its centre.
    pub area: bool,
    /// Maximum number of blocks of 8 × 8 texels, if each tile is only as fine as it needs to be; each bin is then a
    /// block. `None` if all tiles are equally fine, and each bin is a tile.
    pub blocks: Option<u32>,
}
