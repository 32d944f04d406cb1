//! Uses of bins by techniques.

/// What is kept per caster of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// Nothing: the technique only asks which casters and tiles meet.
    None,
    /// The caster, with the depth to sort by.
    Sorted,
    /// The caster, with the most optical depth that it adds to any ray: for sums in any order.
    Summed,
}

/// Uses of bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use {
    /// The data kept about each tile's casters.
    pub entries: Entries,
    /// Whether casters in the dark behind meshes may be left out.
    pub skip: bool,
    /// Texels around a tile from which look-ups read it.
    pub reach: u32,
    /// Workgroups per tile in [`crate::maps::Bins::per_part`]: for a tile with casters, and for one without.
    pub parts: [u32; 2],
    /// Whether a texel stands for all of its square, instead of only for the ray through its centre.
    pub area: bool,
    /// The most blocks of 8 × 8 texels, where each tile is as fine as it needs to be; each bin is then a block. None:
    /// all tiles are equally fine, and each bin is a tile.
    pub blocks: Option<u32>,
}
