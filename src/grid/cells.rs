//! Counts of occupied voxels in cells of at least 8 voxels per side, for cone tracing.

use super::{GridPush, THREADS};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, groups};
use crate::shaders::grid::CELLS;
use crate::shaders::set;
use bytemuck::Zeroable;

/// Base-2 logarithm of the voxels per side of the smallest cells. Twin: CELLS_FIRST in glsl/grid/cells.glsl.
const FIRST: u32 = 3;

/// Counts for cells of all sizes, up to the whole grid.
pub(super) struct Cells {
    size: u32,
    pub(super) counts: Buffer,
    kernel: Kernel<GridPush>,
}

impl Cells {
    /// Creates the cells of a grid whose buffers are in the set `grid`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub(super) fn new(context: &Context, size: u32, grid: &Bindings) -> Result<Self> {
        let bytes = 4 * u64::from(count(size));
        let counts = Buffer::new(context, "grid.cells", bytes, Memory::Device)?;
        let set = set::GridCells { counts: &counts }.bind(context, "grid.cells")?;
        let kernel = Kernel::compute(context, &CELLS, &[grid, &set], &Constants::new())?;
        Ok(Self { size, counts, kernel })
    }

    /// Counts occupied voxels, level by level.
    pub(super) fn record(&self, commands: &mut Commands) {
        for level in FIRST..=self.size.ilog2() {
            let cells = u64::from(self.size >> level).pow(3);
            let [x, y] = groups(cells.div_ceil(u64::from(THREADS)));
            commands.pass("grid.cells", |pass| {
                pass.dispatch(&self.kernel, &GridPush { level, ..GridPush::zeroed() }, [x, y, 1]);
            });
        }
    }
}

/// Returns the number of cells in all levels.
pub(super) fn count(size: u32) -> u32 {
    (FIRST..=size.ilog2()).map(|level| (size >> level).pow(3)).sum()
}
