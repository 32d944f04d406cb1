//! Masks: one 64-bit word per occupied voxel, with a bit for each of its 4 × 4 × 4 cells, in voxel order. The buffer grows with the number
//! of occupied voxels.

use super::{GridPush, THREADS, Voxelize, Voxelizer, side};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, ReadBack};
use crate::shaders::grid as shaders;
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Result};
use bytemuck::Zeroable;

/// Number of bricks per workgroup. Twin: THREADS times BRICKS in glsl/grid/number.comp.
const RUN: u32 = THREADS * 16;

/// Initial capacity, in layers of the grid.
const FIRST_LAYERS: u64 = 4;

/// Size of a mask, in bytes.
const MASK_BYTES: u64 = 8;

/// The masks, and the passes that fill them.
pub(super) struct Masks {
    context: Context,
    size: u32,
    /// The masks, in the layout of glsl/grid/masks.glsl.
    pub(super) words: Buffer,
    runs: Buffer,
    /// Number of occupied voxels, for the host.
    counted: ReadBack,
    set: Bindings,
    number: [Kernel<GridPush>; 3],
    voxelize: Voxelize,
}

/// Returns the size in bytes of the first part of the buffer, which stores, per brick, the number of occupied voxels before it.
fn numbers_bytes(size: u32) -> u64 {
    4 * u64::from(side(size, 0).pow(3))
}

fn words(context: &Context, size: u32, masks: u64) -> Result<Buffer> {
    let (wants, has) = (numbers_bytes(size) + MASK_BYTES * masks, context.features().max_storage_buffer_range);
    if wants > u64::from(has) {
        let needs = format!(
            "maxStorageBufferRange of at least {wants} for the masks of {masks} voxels (this device has {has})"
        );
        return Err(Error::Refused(needs.into()));
    }
    Buffer::new(context, "grid.masks", wants, Memory::Device)
}

impl Masks {
    /// Creates masks for a grid whose buffers are in the set `grid`.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub(super) fn new(
        context: &Context,
        world: &World,
        size: u32,
        voxelizer: Voxelizer,
        grid: &Bindings,
    ) -> Result<Self> {
        let words = words(context, size, FIRST_LAYERS * u64::from(size).pow(2))?;
        let bytes = 4 * (1 + u64::from(side(size, 0).pow(3) / RUN));
        let runs = Buffer::new(context, "grid.runs", bytes, Memory::Device)?;
        let counted = ReadBack::new(context, "grid.counted", bytes)?;
        let set = set::GridMasks { masks: &words, runs: &runs }.bind(context, "grid.masks")?;
        let kernel = |shader| Kernel::compute(context, shader, &[grid, &set], &Constants::new());
        let number =
            [kernel(&shaders::NUMBER_STEP_0)?, kernel(&shaders::NUMBER_STEP_1)?, kernel(&shaders::NUMBER_STEP_2)?];
        let voxelize = Voxelize::new(context, voxelizer, &[grid, &set], world.constants())?;
        Ok(Self { context: context.clone(), size, words, runs, counted, set, number, voxelize })
    }

    /// Fills the masks of the occupied voxels from the triangles. `large` lists the triangles that overlap many cells.
    pub(super) fn record(&self, commands: &mut Commands, world: &World, large: &Buffer) {
        let runs = side(self.size, 0).pow(3) / RUN;
        for (kernel, groups) in self.number.iter().zip([runs, 1, runs]) {
            commands.pass("grid.number", |pass| pass.dispatch(kernel, &GridPush::zeroed(), [groups, 1, 1]));
        }
        commands.read_back(&self.runs, &self.counted);
        let first = numbers_bytes(self.size);
        commands.pass("grid.mask", |pass| {
            pass.fill_part(&self.words, first, self.words.bytes() - first, 0);
            pass.fill_part(large, 0, super::LISTS_BYTES, 0);
        });
        self.voxelize.record(commands, "grid.mask", world, MASK_SIDE * self.size);
    }

    /// Enlarges the buffer to hold the masks of the occupied voxels of the completed frame `frame`; returns whether the buffer grew.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device cannot bind a buffer of that size, [`Error::Gpu`] if memory runs out.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        let Some(counted) = self.counted.read::<u32>(frame, 1)? else { return Ok(false) };
        let (wants, first) = (counted.first().map_or(0, |count| u64::from(*count)), numbers_bytes(self.size));
        if first + MASK_BYTES * wants <= self.words.bytes() {
            return Ok(false);
        }
        // An eighth more than needed, so that the buffer of an animated scene does not grow every frame.
        self.words = words(&self.context, self.size, wants + wants / 8)?;
        self.set.replace(set::GridMasks::MASKS, &self.words)?;
        // Frames already recorded used a smaller buffer, so their counts do not show what fits now.
        self.counted.forget();
        Ok(true)
    }

    /// Returns the number of bytes that only a build needs.
    pub(super) fn transient_bytes(&self) -> u64 {
        self.runs.bytes()
    }

    /// Reads the buffer, up to its last mask.
    ///
    /// # Errors
    /// [`Error::Gpu`] if it cannot be read back.
    pub(super) fn read(&self) -> Result<Vec<u32>> {
        let masks = self.runs.read::<u32>(1)?[0];
        self.words.read((side(self.size, 0).pow(3) + 2 * masks) as usize)
    }
}

/// Number of cells per side of a voxel. Twin: FACET_CELLS in glsl/grid/occupy_cell.glsl.
pub(super) const MASK_SIDE: u32 = 4;
