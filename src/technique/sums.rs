//! What techniques share that keep sums of a ray's optical depth over a range of depths: between which depths, and in how many bits.

use super::keys::words;
use super::settings::Setting;

words! {
    /// The depths that a texel's sums are of.
    pub enum Range {
        /// All of the map's.
        Scene = "scene",
        /// From the texel's front to its back.
        Texel = "texel",
    }
}

impl Range {
    /// SUM_RANGE of glsl/maps/sums/range.glsl, which is also the words that it takes of a texel.
    pub fn constant(self) -> u32 {
        match self {
            Self::Scene => 0,
            Self::Texel => 2,
        }
    }
}

/// The key of the range.
pub const RANGE: Setting<Range> =
    Setting::word("texel", "sums over all of the map's depths, or from each texel's front to its back");

words! {
    /// What sums are kept in. Twins: STORAGE_F32 and so on.
    pub enum Storage {
        /// 32 bits.
        F32 = "r32f",
        /// Half floats.
        F16 = "r16f",
    }
}

impl Storage {
    /// Words of so many sums. Twin: words_of.
    pub fn words(self, count: u32) -> u32 {
        if self == Self::F32 { count } else { count.div_ceil(2) }
    }
}

/// The key of the storage.
pub const STORAGE: Setting<Storage> = Setting::word("r32f", "4 bytes a sum, or half floats");
