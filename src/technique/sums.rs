//! Code shared by techniques that store sums of a ray's optical depth: the depth range, and the bits per sum.

use super::keys::words;
use super::settings::Setting;
use super::texel_map::{BINNED, RASTER};
use super::{Path, Promises};
use crate::gpu::{Limit, Requirement};
use crate::maps::{TexelWay, leveled_texels, sum_targets};

words! {
    /// Depth range of a texel's sums.
    pub enum Range {
        /// The whole depth of the map.
        Scene = "scene",
        /// From the texel's front to its back.
        Texel = "texel",
    }
}

impl Range {
    /// Returns SUM_RANGE of glsl/maps/sums/range.glsl, which is also the number of words that the range takes in a texel.
    pub fn constant(self) -> u32 {
        match self {
            Self::Scene => 0,
            Self::Texel => 2,
        }
    }
}

/// Setting for the depth range.
pub const RANGE: Setting<Range> =
    Setting::word("texel", "sums over the map's whole depth, or from each texel's front to its back");

words! {
    /// Storage format of sums. Twins: STORAGE_F32 and so on.
    pub enum Storage {
        /// 32 bits.
        F32 = "r32f",
        /// Half floats.
        F16 = "r16f",
    }
}

impl Storage {
    /// Returns the number of words that `count` sums take. Twin: words_of.
    pub fn words(self, count: u32) -> u32 {
        if self == Self::F32 { count } else { count.div_ceil(2) }
    }
}

/// Setting for the storage format.
pub const STORAGE: Setting<Storage> = Setting::word("r32f", "4 bytes per sum, or half floats");

/// Paths of all techniques with sums.
pub const PATHS: &[Path] =
    &[Path { name: BINNED, requires: &[] }, Path { name: RASTER, requires: &[Requirement::FragmentStores] }];

/// Returns the promises of a path. The sum over all casters on a ray is right except for rounding: each sum is rounded when it is stored,
/// and each caster's contribution is rounded to an integer, which becomes noticeable with thousands of casters on the ray. Integer sums do
/// not depend on the order of casters; drawn sums are rounded at each caster.
pub fn promises(path: &Path) -> Promises {
    let order = if path.is(TexelWay::Binned) { 0.0 } else { 1e-3 };
    Promises { tail: Some(1e-3), order: Some(order), ..Promises::OF_DEPTH }
}

/// Returns the limits of a path with `sums` sums in `words` words per texel, for maps of `size` texels per side with `levels` levels of
/// detail. Devices that do not meet them are refused.
pub fn limits(path: &Path, [sums, words]: [u32; 2], size: u32, levels: u32) -> Vec<Limit> {
    let mut limits = vec![Limit::buffer_range(4 * u64::from(words) * leveled_texels(size, levels))];
    if !path.is(TexelWay::Binned) {
        limits.extend([sum_targets(sums), Limit::image_2d(size.into())]);
    }
    limits
}

/// Declares the kernels of the technique whose shaders are named `$name`. `$sums`: sums per texel. `$words`: words per texel. `$levels`:
/// levels of detail. `$cells`: cells of a coarser level's range.
macro_rules! sum_kernels {
    ($name:ident, $sums:expr, $words:expr, $levels:expr, $cells:expr) => {
        $crate::maps::SumKernels {
            labels: [
                concat!(stringify!($name), ".binned"),
                concat!(stringify!($name), ".raster"),
                concat!(stringify!($name), ".pack"),
                concat!(stringify!($name), ".levels"),
            ],
            sums: $sums,
            words: $words,
            binned: &$crate::shaders::$name::BINNED,
            raster: [
                &$crate::shaders::$name::RASTER_FRAG_TARGETS_1,
                &$crate::shaders::$name::RASTER_FRAG_TARGETS_2,
                &$crate::shaders::$name::RASTER_FRAG_TARGETS_4,
                &$crate::shaders::$name::RASTER_FRAG_TARGETS_8,
            ],
            pack: &$crate::shaders::$name::PACK,
            levels: &$crate::shaders::$name::LEVELS,
            level_count: $levels,
            level_cells: $cells,
        }
    };
}
pub(super) use sum_kernels;
