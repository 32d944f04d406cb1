//! Finds the voxels that triangles overlap, or the cells of their masks.

use super::lists::Lists;
use super::{GridPush, LARGE_GROUPS, THREADS};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Draw, Graphics, Kernel, groups};
use crate::shaders::constant::CONSERVATIVE;
use crate::shaders::grid as shaders;
use crate::world::World;
use bytemuck::Zeroable;

/// The method for finding the voxels that a triangle overlaps. All except [`Voxelizer::Listed`] find the same voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voxelizer {
    /// Compute passes iterate over the voxels in the triangles' boxes.
    Compute,
    /// Same as `Compute`, but the triangles of each voxel are listed as well, and each voxel is tested slightly enlarged.
    Listed,
    /// Triangles are drawn along their dominant axis, and fragments iterate over columns of voxels.
    Raster {
        /// Whether fragments cover everything that a triangle touches by [`crate::gpu::Features::conservative_rasterization`]; otherwise by
        /// widening the triangles.
        conservative: bool,
    },
}

/// The passes of a [`Voxelizer`].
pub(super) enum Voxelize {
    Compute([Kernel<GridPush>; 3]),
    Listed(Box<Lists>),
    Raster(Kernel<GridPush>),
}

impl Voxelize {
    /// Creates the passes that fill the grid in the first of `sets`, or masks if there is a second set that holds them. Lists have their
    /// own passes. `constants` are the world's.
    pub(super) fn new(
        context: &Context,
        voxelizer: Voxelizer,
        sets: &[&Bindings],
        constants: Constants,
    ) -> Result<Self> {
        let kernel = |shader| Kernel::compute(context, shader, sets, &constants);
        let is_mask = sets.len() > 1;
        Ok(match voxelizer {
            Voxelizer::Compute | Voxelizer::Listed if is_mask => Self::Compute([
                kernel(&shaders::MASK_STEP_0)?,
                kernel(&shaders::MASK_STEP_1)?,
                kernel(&shaders::MASK_STEP_2)?,
            ]),
            Voxelizer::Compute | Voxelizer::Listed => Self::Compute([
                kernel(&shaders::VOXELIZE_STEP_0)?,
                kernel(&shaders::VOXELIZE_STEP_1)?,
                kernel(&shaders::VOXELIZE_STEP_2)?,
            ]),
            Voxelizer::Raster { conservative } => {
                let (vertex, fragment) = if is_mask {
                    (&shaders::VOXELIZE_VERT_MASK_1, &shaders::VOXELIZE_FRAG_MASK_1)
                } else {
                    (&shaders::VOXELIZE_VERT_MASK_0, &shaders::VOXELIZE_FRAG_MASK_0)
                };
                let state = Graphics { vertex, fragment, colors: &[], depth: None };
                let constants = constants.set(CONSERVATIVE, conservative);
                let make = if conservative { Kernel::touching } else { Kernel::graphics };
                Self::Raster(make(context, &state, sets, &constants)?)
            }
        })
    }

    /// Records the passes; `size` is the number of voxels per side, or of cells per side for masks.
    pub(super) fn record(&self, commands: &mut Commands, label: &'static str, world: &World, size: u32) {
        let triangle_count = world.triangle_count();
        let push = GridPush { triangle_count, ..GridPush::zeroed() };
        let compute = match self {
            Self::Compute(kernels) => kernels,
            Self::Listed(lists) => return lists.record(commands, world),
            Self::Raster(kernel) => {
                return commands.pass(label, |pass| {
                    let draw = |draw: &mut Draw| draw.draw(kernel, &push, 3 * triangle_count, 1);
                    pass.render([size; 2], &[], None, draw);
                });
            }
        };
        let [x, y] = groups(u64::from(triangle_count.div_ceil(THREADS)));
        commands.pass(label, |pass| pass.dispatch(&compute[0], &push, [x, y, 1]));
        commands.pass(label, |pass| {
            pass.dispatch(&compute[1], &push, [LARGE_GROUPS, 1, 1]);
            pass.dispatch(&compute[2], &push, [LARGE_GROUPS, 1, 1]);
        });
    }
}
