//! The order in which a picture blends casters, from far to near by the z of their middles, sorted on the device. Equal ones keep the
//! order of their indices. Twin: reference::twin::far_to_near.

use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, groups, push_struct};
use crate::maps::Order;
use crate::scene::{Scene, View};
use crate::shaders::{consume as shaders, set};
use crate::world::World;

push_struct! {
    /// Twin: FarToNearPush in glsl/consume/far_to_near.comp.
    struct FarToNearPush {
        /// Where the camera stands.
        origin: [f32; 3],
        count: u32,
        forward: [f32; 3],
    }
}

/// Sorts a world's casters for a camera.
pub struct FarToNear {
    order: Order,
    keys: Kernel<FarToNearPush>,
}

impl FarToNear {
    /// The most casters that `world` blends at once: all but the cells of volumes.
    pub(super) fn room(world: &World) -> u32 {
        let cells = world.scene().map_or(0, Scene::most_cells);
        world.caster_capacity().saturating_sub(cells as u32)
    }

    /// Room for all casters of `world` that are no cells.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World) -> Result<Self> {
        let order = Order::new(context, Self::room(world), 1)?;
        let set = set::FarToNear { casters: &world.casters, items: &order.items }.bind(context, "far_to_near")?;
        Ok(Self { keys: Kernel::compute(context, &shaders::FAR_TO_NEAR, &[&set], &Constants::new())?, order })
    }

    /// Records the passes that sort the world's first `count` casters.
    pub fn record(&self, commands: &mut Commands, camera: &View, count: u32) {
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = FarToNearPush { origin: camera.origin, count, forward: camera.forward };
        commands.pass("consume.far_to_near", |pass| pass.dispatch(&self.keys, &push, [x, y, 1]));
        self.order.sort(commands, count);
    }

    /// The result: indices of casters.
    pub fn sorted(&self) -> &Buffer {
        &self.order.sorted
    }
}
