//! Detail of each map tile, surveyed and chosen on the device, with at most a given number of blocks of 8×8 texels.

use super::Maps;
use super::bins::{BinPush, TILE_TEXELS};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, push_struct};
use crate::maps::bins::threads::{Surveying, Threads};
use crate::shaders;
use crate::shaders::constant::{LISTS, SHARING, THREADS, WORKGROUP};
use crate::shaders::set;
use bytemuck::{Pod, Zeroable};

/// Table words per tile, and maximum number of blocks per tile. Twin: SLOTS in glsl/maps/detail/blocks.glsl.
pub const SLOTS: u32 = 64;

/// Number of texels per block.
pub const BLOCK_TEXELS: u32 = TILE_TEXELS * TILE_TEXELS;

/// Maximum number of blocks that a word of the table can distinguish.
pub const MOST_BLOCKS: u32 = (1 << 28) - 1;

/// The survey of a tile. Twin: Survey in glsl/maps/detail/survey.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Survey {
    /// Bit 4 y + x is set if a caster meets cell (x, y) of 4 × 4.
    pub cells: u32,
    /// Sum of edge lengths, each times the fraction of light that the edge absorbs.
    pub edges: u32,
    /// Mean optical depth over the tile.
    pub optical_depth: u32,
}

push_struct! {
    /// Twin: ChoosePush in glsl/maps/detail/choose.comp.
    struct ChoosePush {
        /// Number of tiles over all maps.
        tile_count: u32,
        /// Number of tiles per row of a map.
        across: u32,
        /// Maximum number of blocks.
        block_count: u32,
    }
}

/// The table of blocks and the passes that fill it.
pub struct Detail {
    /// Table of blocks: map after map, rows of tiles. glsl/maps/detail/blocks.glsl defines the layout of its words.
    slots: Buffer,
    /// [`Survey`] of each tile.
    surveys: Buffer,
    /// Number of blocks, then the slot of each block in the order of the blocks' positions; filled only if requested.
    listed: Buffer,
    set: Bindings,
    survey: Kernel<BinPush>,
    surveying: Surveying,
    choose: Kernel<ChoosePush>,
    push: ChoosePush,
}

/// Allocates the table of the blocks of all tiles.
///
/// # Errors
/// [`crate::Error::Gpu`] if memory runs out.
pub(super) fn slots(context: &Context, maps: &Maps) -> Result<Buffer> {
    Buffer::new(context, "detail.slots", table_bytes(maps), Memory::Device)
}

/// Returns the size of the table, in bytes.
pub fn table_bytes(maps: &Maps) -> u64 {
    tile_count(maps) * u64::from(SLOTS) * 4
}

/// Returns the number of tiles over all maps. Each tile is at least one block.
pub fn tile_count(maps: &Maps) -> u64 {
    let [x, y] = maps.tiles().map(u64::from);
    x * y * u64::from(maps.count())
}

impl Detail {
    /// Creates the buffers and passes of detail. `bins` is the set of the [`super::Bins`], which holds `slots`. At most
    /// `block_count` blocks are chosen, which must be no fewer than there are tiles.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub(super) fn new(
        context: &Context,
        maps: &Maps,
        bins: &Bindings,
        slots: Buffer,
        block_count: u32,
        threads: &Threads,
        constants: &Constants,
    ) -> Result<Self> {
        let tiles = tile_count(maps);
        let surveys = Buffer::new(context, "detail.surveys", tiles * size_of::<Survey>() as u64, Memory::Device)?;
        let listed = if threads.fullest_first { u64::from(block_count) + 1 } else { 1 };
        let listed = Buffer::new(context, "detail.listed", listed * 4, Memory::Device)?;
        let set = set::Detail { surveys: &surveys, listed: &listed }.bind(context, "detail")?;
        let sets = [maps.scene(), bins, &set];
        let Surveying { tallies, threads: alone, sharing, .. } = threads.surveying;
        let survey = if tallies { &shaders::detail::SURVEY_TALLY_1 } else { &shaders::detail::SURVEY_TALLY_0 };
        let of_survey = constants.clone().set(THREADS, alone).set(WORKGROUP, alone).set(SHARING, sharing);
        let of_choice = constants.clone().set(LISTS, threads.fullest_first);
        Ok(Self {
            survey: Kernel::compute(context, survey, &sets, &of_survey)?,
            surveying: threads.surveying,
            choose: Kernel::compute(context, &shaders::detail::CHOOSE, &sets, &of_choice)?,
            listed,
            set,
            push: ChoosePush { tile_count: tiles as u32, across: maps.tiles()[0], block_count },
            slots,
            surveys,
        })
    }

    /// Returns the table of blocks.
    pub fn slots(&self) -> &Buffer {
        &self.slots
    }

    /// Returns the [`Survey`] of each tile: map after map, rows of tiles.
    pub fn surveys(&self) -> &Buffer {
        &self.surveys
    }

    /// Returns the set with the surveys and the list of blocks.
    pub(super) fn set(&self) -> &Bindings {
        &self.set
    }

    /// Returns the bytes of the buffers that no look-up needs.
    pub(super) fn bytes_transient(&self) -> u64 {
        self.surveys.bytes() + self.listed.bytes()
    }

    /// Returns the maximum number of blocks.
    pub fn block_count(&self) -> u32 {
        self.push.block_count
    }

    /// Surveys the casters of `push.map_count` maps. The surveys must have been cleared to 0.
    pub(super) fn survey(&self, commands: &mut Commands, push: &BinPush) {
        let [x, y] = self.surveying.groups(push.caster_count);
        let groups = [x, y, push.map_count];
        commands.pass("detail.survey", |pass| pass.dispatch(&self.survey, push, groups));
    }

    /// Chooses how fine each tile is.
    pub(super) fn choose(&self, commands: &mut Commands) {
        commands.pass("detail.choose", |pass| pass.dispatch(&self.choose, &self.push, [1; 3]));
    }
}
