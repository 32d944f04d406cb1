//! Smoke and hair in a grid: for each voxel, the optical depth along one voxel's length.

use super::{GridPush, LISTS_BYTES, THREADS, grid_words, side};
use crate::gpu::{Bindings, Buffer, Commands, Context, Kernel, Limit, Memory, groups};
use crate::shaders::constant::FACING;
use crate::shaders::grid as shaders;
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Result};
use bytemuck::Zeroable;

/// Number of workgroups that share the casters overlapping many voxels.
const LARGE_GROUPS: u32 = 4096;

/// Extra data of smoke and hair in a grid, besides a number per voxel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediaContent {
    /// Whether the grid stores the directions of the strands in each voxel, or the normals of the sheets if there are no strands.
    pub directions: bool,
    /// Whether the grid stores the maximum over all voxels.
    pub most: bool,
}

/// An optical depth per voxel, and bits that mark the voxels with smoke or hair.
pub(super) struct Media {
    size: u32,
    /// Optical depths along one voxel's length, brick by brick, in the layout of glsl/grid/media.glsl.
    pub(super) voxels: Buffer,
    /// Occupancy bits, in the order of the grid's bits.
    pub(super) bits: Buffer,
    pub(super) large: Buffer,
    clear: Kernel<GridPush>,
    deposit: [Kernel<GridPush>; 3],
    directions: Option<(Buffer, Kernel<GridPush>)>,
    most: Option<(Buffer, Kernel<GridPush>)>,
}

/// Returns the limit for a device whose largest storage buffer must hold `numbers` numbers per voxel.
pub fn media_limit(size: u32, numbers: u64) -> Limit {
    Limit::buffer_range(4 * numbers * u64::from(size).pow(3))
}

/// Returns whether the directions are the normals of sheets. Beside strands they are not stored.
pub(crate) fn faces(world: &World) -> bool {
    world.has_sheets() && !world.has_strands()
}

/// Returns the size in bytes of `numbers` numbers per voxel, if the device can bind that much.
fn bytes(context: &Context, size: u32, numbers: u64) -> Result<u64> {
    let limit = media_limit(size, numbers);
    match limit.lacks(context.features(), &format!(" for smoke and hair in {size}³ voxels")) {
        Some(needs) => Err(Error::Refused(needs)),
        None => Ok(limit.least),
    }
}

impl Media {
    /// Creates the media of a grid whose buffers are in the set `grid`.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device cannot bind a buffer with one number per voxel, [`Error::Gpu`] if memory runs out.
    pub(super) fn new(
        context: &Context,
        world: &World,
        size: u32,
        grid: &Bindings,
        holds: MediaContent,
    ) -> Result<Self> {
        let voxels = Buffer::zeroed(context, "grid.media", bytes(context, size, 1)?)?;
        let bits = Buffer::zeroed(context, "grid.media_bits", 8 * u64::from(grid_words(size)))?;
        let listed = LISTS_BYTES + 4 * u64::from(world.caster_capacity());
        let large = Buffer::new(context, "grid.media_large", listed, Memory::Device)?;
        let set = set::GridCast { casters: &world.casters, media: &voxels, media_bits: &bits, cast_listed: &large };
        let set = set.bind(context, "grid.cast")?;
        let constants = world.constants().set(FACING, faces(world));
        let kernel = |shader| Kernel::compute(context, shader, &[grid, &set], &constants);
        let clear = kernel(&shaders::CLEAR_MEDIA)?;
        let deposit =
            [kernel(&shaders::DEPOSIT_STEP_0)?, kernel(&shaders::DEPOSIT_STEP_1)?, kernel(&shaders::DEPOSIT_STEP_2)?];
        let mut directions = None;
        if holds.directions {
            let words = Buffer::new(context, "grid.directions", bytes(context, size, 6)?, Memory::Device)?;
            let run = set::GridDirections { directions: &words }.bind(context, "grid.directions")?;
            let kernel = Kernel::compute(context, &shaders::DIRECTIONS, &[grid, &set, &run], &constants)?;
            directions = Some((words, kernel));
        }
        let mut most = None;
        if holds.most {
            let word = Buffer::new(context, "grid.most", 4, Memory::Device)?;
            let greatest = set::GridMost { most: &word }.bind(context, "grid.most")?;
            let kernel = Kernel::compute(context, &shaders::MOST, &[grid, &set, &greatest], &constants)?;
            most = Some((word, kernel));
        }
        Ok(Self { size, voxels, bits, large, clear, deposit, directions, most })
    }

    pub(super) fn directions(&self) -> Option<&Buffer> {
        self.directions.as_ref().map(|(words, _)| words)
    }

    pub(super) fn most(&self) -> Option<&Buffer> {
        self.most.as_ref().map(|(word, _)| word)
    }

    pub(super) fn resident_bytes(&self) -> u64 {
        let held = [self.directions(), self.most()].into_iter().flatten();
        self.voxels.bytes() + self.bits.bytes() + held.map(Buffer::bytes).sum::<u64>()
    }

    /// Empties the media. Only non-empty bricks of `voxels` are cleared.
    pub(super) fn clear(&self, commands: &mut Commands) {
        let [x, y] = groups(u64::from(side(self.size, 1).pow(3)));
        let top = u64::from(side(self.size, 2).pow(3));
        commands.pass("grid.clear_media", |pass| {
            pass.dispatch(&self.clear, &GridPush::zeroed(), [x, y, 1]);
        });
        commands.pass("grid.clear_media", |pass| {
            pass.fill_part(&self.large, 0, LISTS_BYTES, 0);
            for held in [self.directions(), self.most()].into_iter().flatten() {
                pass.fill(held, 0);
            }
            pass.fill_part(&self.bits, self.bits.bytes() - 8 * top, 8 * top, 0);
        });
    }

    /// Deposits the casters in a grid whose placement is set.
    pub(super) fn deposit(&self, commands: &mut Commands, world: &World) {
        let caster_count = world.caster_count();
        if caster_count == 0 {
            return;
        }
        let push = GridPush { caster_count, ..GridPush::zeroed() };
        let [x, y] = groups(u64::from(caster_count.div_ceil(THREADS)));
        commands.pass("grid.deposit", |pass| pass.dispatch(&self.deposit[0], &push, [x, y, 1]));
        commands.pass("grid.deposit", |pass| {
            pass.dispatch(&self.deposit[1], &push, [LARGE_GROUPS, 1, 1]);
            pass.dispatch(&self.deposit[2], &push, [LARGE_GROUPS, 1, 1]);
        });
        if let Some((_, kernel)) = &self.directions {
            let [x, y] = if faces(world) { groups(u64::from(caster_count)) } else { [x, y] };
            commands.pass("grid.directions", |pass| pass.dispatch(kernel, &push, [x, y, 1]));
        }
        if let Some((_, kernel)) = &self.most {
            let [x, y] = groups(u64::from(side(self.size, 1).pow(3)));
            commands.pass("grid.most", |pass| pass.dispatch(kernel, &push, [x, y, 1]));
        }
    }
}
