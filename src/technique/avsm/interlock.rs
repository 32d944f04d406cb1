//! path=interlock: each fragment inserts its segment into its texel's curve as it is drawn, one fragment per texel at a time, in drawing
//! order. Source: Fife and Strugar 2013, Pixel Shader Ordering.

use super::{GroupPush, NodeData, Site, per_tile};
use crate::Result;
use crate::gpu::{Buffer, Commands, Kernel, Memory};
use crate::maps::{Bins, CasterQuads, Maps, QuadsPush};
use crate::shaders::{self, set};
use crate::world::World;
use std::ops::Range;

/// The build state of this path.
pub struct Interlock {
    quads: CasterQuads,
    clear: Kernel<GroupPush>,
    insert: Kernel<QuadsPush>,
    pack: Kernel<GroupPush>,
    /// Nodes of a group of maps in full precision, before they are packed: each fragment reads back the nodes written by earlier fragments,
    /// which must not be quantized. `None` if nodes are not packed.
    full: Option<Buffer>,
    /// Number of maps drawn at once.
    at_once: u32,
}

impl Interlock {
    pub fn new(site: &Site) -> Result<Self> {
        let Site { context, world, maps, bins, curves, plan } = *site;
        let quads = CasterQuads::new(context, world, maps, plan.settings.drawing_order(), bins)?;
        let mut at_once = maps.stacked_at_once(context);
        let mut set = curves.set.clone();
        let mut full = None;
        if plan.settings.is_packed() {
            let map_bytes = u64::from(maps.size()[0])
                * u64::from(maps.size()[1])
                * u64::from(plan.settings.nodes)
                * size_of::<NodeData>() as u64;
            let fit = u64::from(context.features().max_storage_buffer_range) / map_bytes;
            at_once = fit.clamp(1, at_once.into()) as u32;
            let nodes = Buffer::new(context, "avsm.full", map_bytes * u64::from(at_once), Memory::Device)?;
            set = set::AvsmFull { nodes: &nodes, counts: &curves.tiles }.bind(context, "avsm.full")?;
            full = Some(nodes);
        }
        let insert = quads.kernel(context, maps, &shaders::avsm::INSERT_FRAG, &[], &[&set], &plan.constants)?;
        let clear = Kernel::compute(context, &shaders::avsm::CLEAR, &[maps.scene(), &set], &plan.constants)?;
        let sets = [maps.scene(), &set, &curves.set];
        let pack = Kernel::compute(context, &shaders::avsm::PACK, &sets, &plan.constants)?;
        Ok(Self { quads, clear, insert, pack, full, at_once })
    }

    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) -> Result<()> {
        self.quads.record(commands, world, maps, bins);
        for (group, of) in (0..).zip(maps.groups(self.at_once)) {
            self.clear(commands, maps, of.clone());
            self.insert(commands, maps, of.clone(), group);
            self.pack(commands, maps, of);
        }
        Ok(())
    }

    /// Empties every curve.
    fn clear(&self, commands: &mut Commands, maps: &Maps, group: Range<u32>) {
        per_tile(commands, "avsm.clear", &self.clear, maps, group);
    }

    /// Draws the casters in each map's drawing order, which inserts their segments into the curves.
    fn insert(&self, commands: &mut Commands, maps: &Maps, of: Range<u32>, group: u32) {
        let size = [maps.size()[0], maps.size()[1] * of.len() as u32];
        commands.pass("avsm.insert", |pass| {
            pass.render(size, &[], None, |draw| self.quads.draw(draw, &self.insert, of, group, 0));
        });
    }

    /// Gathers the nodes of each curve in a group into contiguous memory, and packs them if the settings ask for that.
    fn pack(&self, commands: &mut Commands, maps: &Maps, group: Range<u32>) {
        per_tile(commands, "avsm.pack", &self.pack, maps, group);
    }

    /// Returns the number of bytes needed only while building.
    pub fn bytes(&self) -> u64 {
        self.quads.bytes() + self.full.as_ref().map_or(0, Buffer::bytes)
    }
}
