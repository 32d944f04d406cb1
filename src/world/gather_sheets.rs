//! The pass that makes casters of see-through triangles. It writes what [`crate::scene::Scene::casters`] has of them.

use super::gather::{Kernels, THREADS};
use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Context, groups, push_struct};
use crate::shaders::constant::ALPHA_FIRST;
use crate::shaders::{set, world as shaders};
use crate::world::Capacity;

push_struct! {
    /// Twin: SheetsPush in glsl/world/gather_sheets.comp.
    pub(super) struct SheetsPush {
        first: u32,
        slots: u32,
    }
}

/// The kernels of the pass.
pub(super) struct GatherSheets(Kernels<SheetsPush>);

impl GatherSheets {
    pub(super) fn new(capacity: Capacity) -> Self {
        Self(Kernels::with(&shaders::GATHER_SHEETS, Constants::new().set(ALPHA_FIRST, capacity.triangles)))
    }

    /// Records the pass for `slots` triangles, whose casters begin at `first`.
    pub(super) fn record(
        &mut self,
        context: &Context,
        commands: &mut Commands,
        (triangles, casters): (&Buffer, &Buffer),
        [first, slots]: [u32; 2],
    ) -> Result<()> {
        let set = set::GatherSheets { triangles, casters };
        let kernel = self.0.of(context, &[triangles], || set.bind(context, "world.gather"))?;
        let [x, y] = groups(u64::from(slots.div_ceil(THREADS).max(1)));
        commands.pass("world.gather", |pass| pass.dispatch(&kernel, &SheetsPush { first, slots }, [x, y, 1]));
        Ok(())
    }
}
