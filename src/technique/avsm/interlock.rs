//! path=interlock: each fragment inserts its segment into its texel's curve as it is drawn, one fragment of a texel at a
//! time, in drawing order. Source: Fife and Strugar 2013, Pixel Shader Ordering.

use super::{Curves, GroupPush, NodeData, Plan};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context, Kernel, Memory, Resource};
use crate::maps::{Bins, DrawingOrder, Maps, Splat, SplatPush};
use crate::shaders;
use crate::world::World;
use std::ops::Range;

/// What the path builds with.
pub struct Interlock {
    splat: Splat,
    clear: Kernel<GroupPush>,
    insert: Kernel<SplatPush>,
    full: Option<Full>,
    /// Maps that are drawn at once.
    at_once: u32,
}

/// What a group of maps is built in before it is packed: nodes that fragments read back must not be rounded.
struct Full {
    nodes: Buffer,
    pack: Kernel<GroupPush>,
}

impl Interlock {
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        bins: Option<&Bins>,
        curves: &Curves,
        plan: &Plan,
    ) -> Result<Self> {
        let splat = Splat::new(context, world, maps, plan.drawing_order(), bins)?;
        let mut at_once = maps.stacked_at_once(context);
        let mut set = curves.set.clone();
        let mut full = None;
        if plan.settings.packed {
            let map_bytes = u64::from(maps.size()[0]) * u64::from(maps.size()[1]) * plan.full_bytes();
            let fit = u64::from(context.features().max_storage_buffer_range) / map_bytes;
            at_once = fit.clamp(1, at_once.into()) as u32;
            let nodes = Buffer::new(context, "avsm.full", map_bytes * u64::from(at_once), Memory::Device)?;
            let resources = [&nodes, &curves.tiles].map(|b| Resource::Buffer(b.clone()));
            set = Bindings::new(context, "avsm.full", &resources)?;
            let sets = [maps.scene(), &set, &curves.set];
            full = Some(Full { nodes, pack: Kernel::compute(context, &shaders::avsm::PACK, &sets, &plan.constants)? });
        }
        let insert = splat.kernel(context, maps, &shaders::avsm::INSERT_FRAG, &[], &[&set], &plan.constants)?;
        let clear = Kernel::compute(context, &shaders::avsm::CLEAR, &[maps.scene(), &set], &plan.constants)?;
        Ok(Self { splat, clear, insert, full, at_once })
    }

    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) -> Result<()> {
        self.splat.record(commands, world, maps, bins)?;
        for (group, of) in (0..).zip(maps.groups(self.at_once)) {
            self.clear(commands, maps, of.clone());
            self.insert(commands, maps, of.clone(), group);
            if let Some(full) = &self.full {
                full.pack(commands, maps, of);
            }
        }
        Ok(())
    }

    /// Empties every curve.
    fn clear(&self, commands: &mut Commands, maps: &Maps, group: Range<u32>) {
        let [x, y] = maps.tiles();
        commands.pass("avsm.clear", |pass| {
            pass.dispatch(&self.clear, &GroupPush { first_map: group.start }, [x, y, group.len() as u32]);
        });
    }

    /// Draws the casters into the curves, in each map's order.
    fn insert(&self, commands: &mut Commands, maps: &Maps, of: Range<u32>, group: u32) {
        let size = [maps.size()[0], maps.size()[1] * of.len() as u32];
        commands.pass("avsm.insert", |pass| {
            pass.render(size, &[], None, |draw| self.splat.draw(draw, &self.insert, of, group, 0));
        });
    }

    /// Bytes that are needed only while building.
    pub fn bytes(&self) -> u64 {
        self.splat.bytes() + self.full.as_ref().map_or(0, |f| f.nodes.bytes())
    }
}

impl Full {
    /// Packs the curves of a group.
    fn pack(&self, commands: &mut Commands, maps: &Maps, group: Range<u32>) {
        let [x, y] = maps.tiles();
        commands.pass("avsm.pack", |pass| {
            pass.dispatch(&self.pack, &GroupPush { first_map: group.start }, [x, y, group.len() as u32]);
        });
    }
}

impl Plan {
    /// Bytes of a texel's nodes in full.
    fn full_bytes(&self) -> u64 {
        u64::from(self.settings.nodes) * size_of::<NodeData>() as u64
    }

    /// Single-pass paths insert casters in the order in which they are drawn.
    pub fn drawing_order(&self) -> DrawingOrder {
        if self.settings.sorted { DrawingOrder::NearToFar } else { DrawingOrder::Index }
    }
}
