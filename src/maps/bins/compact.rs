//! Gathers the casters of each map that meet some tile, in drawing order, with many workgroups: mark, scan, compact.

use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, Memory, groups, push_struct};
use crate::shaders::bins as shaders;
use crate::shaders::set;

/// Bytes of a draw command: vertices, instances, first vertex, first instance.
pub const COMMAND_BYTES: u64 = 16;

/// Casters per block. Twin: 32 BLOCK_WORDS in glsl/maps/bins/marks.glsl.
const BLOCK_CASTERS: u32 = 32 * 64;

push_struct! {
    /// Twin: CompactPush in glsl/maps/bins/marks.glsl.
    struct CompactPush {
        caster_count: u32,
        /// Capacity of each map's drawing order, in casters: map m's order begins at `m · capacity`.
        capacity: u32,
    }
}

/// The passes and their buffers.
pub struct Compact {
    /// Casters that meet a tile; map m's casters begin at `m · capacity`.
    pub drawn: Buffer,
    /// One VkDrawIndirectCommand per map.
    pub draws: Buffer,
    marks: Buffer,
    blocks: Buffer,
    capacity: u32,
    map_count: u32,
    mark: Kernel<CompactPush>,
    scan: Kernel<CompactPush>,
    compact: Kernel<CompactPush>,
}

impl Compact {
    /// Creates the passes for `map_count` maps of at most `capacity` casters each. `met` holds one word per caster and
    /// map, map after map: whether the caster meets a tile of the map. `order` holds the drawing order of each map,
    /// which begins at `m · capacity` for map m.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, met: &Buffer, order: &Buffer, capacity: u32, map_count: u32) -> Result<Self> {
        let buffer = |name, count: u64| Buffer::new(context, name, 4 * count, Memory::Device);
        let blocks = u64::from(capacity.div_ceil(BLOCK_CASTERS)) * u64::from(map_count);
        let drawn = buffer("quads.casters", u64::from(capacity) * u64::from(map_count))?;
        let marks = buffer("bins.marks", blocks * u64::from(BLOCK_CASTERS / 32))?;
        let blocks = buffer("bins.blocks", blocks)?;
        let draws = buffer("quads.draws", COMMAND_BYTES / 4 * u64::from(map_count))?;
        let set = set::BinsCompact { met, order, marks: &marks, blocks: &blocks, drawn: &drawn, draws: &draws };
        let set = set.bind(context, "bins.compact")?;
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &Constants::new());
        Ok(Self {
            mark: kernel(&shaders::MARK)?,
            scan: kernel(&shaders::SCAN)?,
            compact: kernel(&shaders::COMPACT)?,
            drawn,
            draws,
            marks,
            blocks,
            capacity,
            map_count,
        })
    }

    /// Gathers the casters. The world currently has `caster_count` casters.
    pub fn record(&self, commands: &mut Commands, caster_count: u32) {
        let push = CompactPush { caster_count, capacity: self.capacity };
        let [x, y] = groups(u64::from(caster_count.div_ceil(BLOCK_CASTERS)));
        let blocks = [x, y, self.map_count];
        commands.pass("bins.mark", |pass| pass.dispatch(&self.mark, &push, blocks));
        commands.pass("bins.scan", |pass| pass.dispatch(&self.scan, &push, [1, 1, self.map_count]));
        commands.pass("bins.compact", |pass| pass.dispatch(&self.compact, &push, blocks));
    }

    /// Returns the size of all buffers, in bytes.
    pub fn bytes(&self) -> u64 {
        [&self.drawn, &self.draws, &self.marks, &self.blocks].into_iter().map(Buffer::bytes).sum()
    }
}
