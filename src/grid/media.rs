//! Smoke and hair in a grid: what a way of one voxel's length through each voxel takes.

use super::{GridPush, LISTS_BYTES, THREADS, grid_words, side};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, groups};
use crate::shaders::grid as shaders;
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Result};
use bytemuck::Zeroable;

/// Workgroups that share the casters of many voxels.
const LARGE_GROUPS: u32 = 4096;

/// A number a voxel, and bits that say where there are any.
pub(super) struct Media {
    size: u32,
    /// As glsl/grid/media.glsl has them: optical depths of one voxel's length, brick by brick.
    pub(super) voxels: Buffer,
    /// In the order of the grid's.
    pub(super) bits: Buffer,
    pub(super) large: Buffer,
    clear: Kernel<GridPush>,
    deposit: [Kernel<GridPush>; 3],
}

/// Bytes of a number a voxel.
fn bytes(size: u32) -> u64 {
    4 * u64::from(size).pow(3)
}

impl Media {
    /// Of a grid whose own buffers are `grid`.
    ///
    /// # Errors
    /// [`Error::Refused`] where the device binds no buffer of a number a voxel, [`Error::Gpu`] where memory runs out.
    pub(super) fn new(context: &Context, world: &World, size: u32, grid: &Bindings) -> Result<Self> {
        let (wants, has) = (bytes(size), context.features().max_storage_buffer_range);
        if wants > u64::from(has) {
            let needs = format!(
                "maxStorageBufferRange of at least {wants} for smoke and hair in {size}³ voxels (this device has {has})"
            );
            return Err(Error::Refused { needs });
        }
        let voxels = Buffer::zeroed(context, "grid.media", wants)?;
        let bits = Buffer::zeroed(context, "grid.media_bits", 8 * u64::from(grid_words(size)))?;
        let listed = LISTS_BYTES + 4 * u64::from(world.caster_capacity());
        let large = Buffer::new(context, "grid.media_large", listed, Memory::Device)?;
        let set = set::GridCast { casters: &world.casters, media: &voxels, media_bits: &bits, cast_listed: &large };
        let set = set.bind(context, "grid.cast")?;
        let kernel = |shader| Kernel::compute(context, shader, &[grid, &set], &Constants::new());
        let clear = kernel(&shaders::CLEAR_MEDIA)?;
        let deposit =
            [kernel(&shaders::DEPOSIT_STEP_0)?, kernel(&shaders::DEPOSIT_STEP_1)?, kernel(&shaders::DEPOSIT_STEP_2)?];
        Ok(Self { size, voxels, bits, large, clear, deposit })
    }

    /// There is nothing anywhere: zeros where there was something.
    pub(super) fn clear(&self, commands: &mut Commands) {
        let [x, y] = groups(u64::from(side(self.size, 1).pow(3)));
        let top = u64::from(side(self.size, 2).pow(3));
        commands.pass("grid.clear_media", |pass| {
            pass.dispatch(&self.clear, &GridPush::zeroed(), [x, y, 1]);
        });
        commands.pass("grid.clear_media", |pass| {
            pass.fill_part(&self.large, 0, LISTS_BYTES, 0);
            pass.fill_part(&self.bits, self.bits.bytes() - 8 * top, 8 * top, 0);
        });
    }

    /// Puts the casters into a grid that stands where it should.
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
    }
}
