//! The order in which a picture blends casters: from far to near by the z of their centres, sorted on the device. Casters at the same z are
//! ordered by their values, so that it does not matter how casters are listed. Twin: reference::twin::far_to_near.

use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Kernel, Memory, groups, push_struct};
use crate::maps::Order;
use crate::scene::{Scene, View};
use crate::shaders::{set, shading as shaders};
use crate::world::World;

push_struct! {
    /// Twin: FarToNearPush in glsl/shading/far_to_near.glsl.
    struct FarToNearPush {
        /// The camera's position.
        origin: [f32; 3],
        count: u32,
        forward: [f32; 3],
    }
}

/// Sorts a world's casters for a camera.
pub struct FarToNear {
    sort: Order,
    keys: Kernel<FarToNearPush>,
    ties: Kernel<FarToNearPush>,
    order: Buffer,
}

impl FarToNear {
    /// Returns the maximum number of casters that `world` blends at once: all except the cells of volumes.
    pub(super) fn room(world: &World) -> u32 {
        let cells = world.scene().map_or(0, Scene::most_cells);
        world.caster_capacity().saturating_sub(cells as u32)
    }

    /// Creates the sort, with buffers for all casters of `world` except cells.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World) -> Result<Self> {
        let room = Self::room(world);
        let sort = Order::new(context, room, 1)?;
        let order = Buffer::new(context, "far_to_near.order", 4 * u64::from(room.max(1)), Memory::Device)?;
        let keyed = set::FarToNear { casters: &world.casters, items: &sort.items }.bind(context, "far_to_near")?;
        let tied = set::FarToNearTies { casters: &world.casters, sorted: &sort.sorted, order: &order };
        let tied = tied.bind(context, "far_to_near.ties")?;
        let constants = world.constants();
        let kernel = |shader, set| Kernel::compute(context, shader, &[set], &constants);
        Ok(Self {
            keys: kernel(&shaders::FAR_TO_NEAR, &keyed)?,
            ties: kernel(&shaders::FAR_TO_NEAR_TIES, &tied)?,
            sort,
            order,
        })
    }

    /// Records the passes that sort the world's first `count` casters.
    pub fn record(&self, commands: &mut Commands, camera: &View, count: u32) {
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = FarToNearPush { origin: camera.origin, count, forward: camera.forward };
        commands.pass("shading.far_to_near", |pass| pass.dispatch(&self.keys, &push, [x, y, 1]));
        self.sort.sort(commands, count);
        commands.pass("shading.far_to_near_ties", |pass| pass.dispatch(&self.ties, &push, [x, y, 1]));
    }

    /// Returns the result: indices of casters.
    pub fn sorted(&self) -> &Buffer {
        &self.order
    }
}
