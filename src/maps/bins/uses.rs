//! Uses of bins by techniques.

/// The entries of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// Nothing: only which casters and tiles meet is wanted.
    None,
    /// Each with the depth that it is sorted by.
    Sorted,
    /// Each with the optical depth that it takes of any ray at most, for adding them up in any order.
    Summed,
}

/// Uses of bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use {
    /// The data kept about each tile's casters.
    pub entries: Entries,
    /// Casters that stand in the dark behind meshes may be left out.
    pub skip: bool,
    /// Texels around a tile from which look-ups read it.
    pub reach: u32,
    /// Workgroups per tile in [`crate::maps::Bins::per_part`]: for a tile with casters, and for one without.
    pub parts: [u32; 2],
    /// Whether a texel stands for all of its square, and not only for the ray through its centre.
    pub area: bool,
    /// The most blocks, where each tile is to be as fine as it needs: bins are then blocks.
    pub blocks: Option<u32>,
}
