//! path=raster-order: the curves are held in color attachments, which the fragments of a texel read and write one at a time, in drawing
//! order. Source: Fife and Strugar 2013, Pixel Shader Ordering.

use super::settings::Settings;
use super::{GroupPush, Site, per_tile};
use crate::gpu::{Commands, Image, Kernel, Limit, OrderedAttachments};
use crate::maps::{Bins, CasterQuads, Maps, QuadsPush};
use crate::scene::FARTHEST;
use crate::shaders::{self, avsm, set};
use crate::world::World;
use crate::{Error, Result};
use std::ops::Range;

/// Storage buffers that technique/avsm/raster_order.frag reads: maps and casters.
const BUFFERS: u32 = 2;

/// The build state of this path.
pub struct RasterOrder {
    quads: CasterQuads,
    attachments: OrderedAttachments,
    insert: Kernel<QuadsPush>,
    unpack: Kernel<GroupPush>,
    /// Value of an empty curve.
    unshadowed: f32,
    /// Number of maps drawn at once.
    at_once: u32,
}

/// Returns the limits of the fragment shader, which has one attachment per two nodes.
pub fn limits(settings: &Settings) -> [Limit; 4] {
    Limit::attachments(settings.nodes / 2, BUFFERS)
}

impl RasterOrder {
    pub fn new(site: &Site) -> Result<Self> {
        let Site { context, world, maps, bins, curves, plan } = *site;
        // Two nodes per attachment.
        let count = plan.settings.nodes / 2;
        if let Some(needs) = limits(&plan.settings).iter().find_map(|limit| limit.lacks(context.features(), "")) {
            return Err(Error::Refused(needs));
        }
        let (insert, unpack) = match count {
            2 => (&avsm::RASTER_ORDER_FRAG_ATTACHMENTS_2, &avsm::UNPACK_ATTACHMENTS_2),
            4 => (&avsm::RASTER_ORDER_FRAG_ATTACHMENTS_4, &avsm::UNPACK_ATTACHMENTS_4),
            _ => (&avsm::RASTER_ORDER_FRAG_ATTACHMENTS_8, &avsm::UNPACK_ATTACHMENTS_8),
        };
        let quads = CasterQuads::new(context, world, maps, plan.settings.drawing_order(), bins)?;
        let at_once = maps.stacked_at_once(context);
        let size = [maps.size()[0], maps.size()[1] * at_once];
        let attachments = OrderedAttachments::new(context, "avsm.attachments", size, count)?;
        let drawn = set::AvsmAttachments { stored: attachments.images() }.bind(context, "avsm.attachments")?;
        let stages = [&shaders::maps::CASTER_QUADS_VERT, insert];
        let sets = [maps.scene(), quads.set(), attachments.inputs()];
        let insert = Kernel::ordered(context, stages, &attachments, &sets, &maps.colored(&plan.constants))?;
        let unpack = Kernel::compute(context, unpack, &[maps.scene(), &curves.set, &drawn], &plan.constants)?;
        let unshadowed = if plan.settings.is_exponential() { 0.0 } else { 1.0 };
        Ok(Self { quads, attachments, insert, unpack, unshadowed, at_once })
    }

    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) -> Result<()> {
        self.quads.record(commands, world, maps, bins);
        for (group, of) in (0..).zip(maps.groups(self.at_once)) {
            self.raster_order(commands, of.clone(), group);
            self.unpack(commands, maps, of);
        }
        Ok(())
    }

    /// Empties every curve, then draws the casters into the curves in each map's drawing order.
    fn raster_order(&self, commands: &mut Commands, of: Range<u32>, group: u32) {
        let clear = [FARTHEST, self.unshadowed, FARTHEST, self.unshadowed];
        commands.pass("avsm.raster_order", |pass| {
            pass.render_ordered(&self.attachments, clear, |draw| self.quads.draw(draw, &self.insert, of, group, 0));
        });
    }

    /// Moves the curves to where look-ups read them.
    fn unpack(&self, commands: &mut Commands, maps: &Maps, group: Range<u32>) {
        per_tile(commands, "avsm.unpack", &self.unpack, maps, group);
    }

    /// Returns the size of the attachments and of the draw's buffers, in bytes.
    pub fn bytes(&self) -> u64 {
        self.quads.bytes() + self.attachments.images().iter().map(Image::bytes).sum::<u64>()
    }
}
