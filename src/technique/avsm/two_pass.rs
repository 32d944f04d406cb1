//! path=two-pass: all segments of each texel are listed, then sorted and compressed. Source: Fife and Strugar 2013, Compression stage.

use super::{GroupPush, Site, per_tile};
use crate::Result;
use crate::gpu::{Commands, Kernel};
use crate::maps::{Bins, CasterQuads, DrawingOrder, Keep, List, Maps};
use crate::shaders;
use crate::world::World;
use std::ops::Range;

/// The build state of this path.
pub struct TwoPass {
    /// Lists of segments.
    pub list: List,
    resolve: Kernel<GroupPush>,
}

impl TwoPass {
    pub fn new(site: &Site) -> Result<Self> {
        let Site { context, world, maps, bins, curves, plan } = *site;
        let quads = CasterQuads::new(context, world, maps, DrawingOrder::Index, bins)?;
        let list = List::new(context, maps, Some(quads), Keep::Some, plan.settings.capacity)?;
        let sets = [maps.scene(), list.set(), &curves.set];
        let shader = if plan.refined { &shaders::avsm::RESOLVE_REFINE_1 } else { &shaders::avsm::RESOLVE_REFINE_0 };
        let resolve = Kernel::compute(context, shader, &sets, &plan.constants)?;
        Ok(Self { list, resolve })
    }

    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) -> Result<()> {
        self.list.begin(commands, world, maps, bins);
        for (group, of) in (0..).zip(maps.groups(self.list.at_once())) {
            self.list.capture(commands, of.clone(), group);
            self.resolve(commands, maps, of);
        }
        Ok(())
    }

    /// Sorts and compresses each list.
    fn resolve(&self, commands: &mut Commands, maps: &Maps, group: Range<u32>) {
        per_tile(commands, "avsm.resolve", &self.resolve, maps, group);
    }
}
