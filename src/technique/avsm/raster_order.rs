//! The curves in colour attachments, into which fragments insert in drawing order, and the way from there to the nodes.

use super::{Avsm, EMPTY};
use crate::gpu::{Bindings, Commands, Context, OrderedAttachments, Pipeline, Resource, shader};
use crate::technique::drawn::Drawn;
use crate::{Error, Result};

/// Storage buffers that avsm/raster_order.frag reads: maps and casters.
const BUFFERS: u32 = 2;

/// What path=raster-order builds with.
pub struct RasterOrder {
    /// What is drawn.
    pub drawn: Drawn,
    attachments: OrderedAttachments,
    curves: Bindings,
    insert: Pipeline,
    unpack: Pipeline,
}

impl RasterOrder {
    /// Makes attachments of `size` texels, which all maps use in turn, for the NODES of `constants`; `drawn` has maps,
    /// casters and drawing orders.
    ///
    /// # Errors
    /// [`Error::Refused`] where the device takes too few attachments, [`Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, size: [u32; 2], drawn: Drawn, nodes: &Bindings, constants: &[u32]) -> Result<Self> {
        // Two nodes an attachment.
        let count = constants[0] / 2;
        if let Some(limit) = context.features().attachment_limit(count, BUFFERS) {
            return Err(Error::Refused { needs: limit });
        }
        let attachments = OrderedAttachments::new(context, "avsm.attachments", size, count)?;
        let textures: Vec<_> = attachments.images().iter().cloned().map(Resource::Texture).collect();
        let curves = Bindings::new(context, "avsm.attachments", &textures)?;
        let stages = [shader("list/caster.vert")?, shader(&format!("avsm/raster_order.frag/{count}"))?];
        let sets = [drawn.bindings(), attachments.inputs()];
        let insert = Pipeline::ordered(context, stages, &attachments, &sets, constants)?;
        let unpack = shader(&format!("avsm/unpack.comp/{count}"))?;
        let unpack = Pipeline::compute(context, unpack, &[nodes, &curves], constants)?;
        Ok(Self { drawn, attachments, curves, insert, unpack })
    }

    /// Bytes of the attachments and of what is drawn.
    pub fn bytes(&self) -> u64 {
        self.drawn.bytes() + self.attachments.images().iter().map(crate::gpu::Image::bytes).sum::<u64>()
    }
}

impl Avsm {
    /// Raster order: empties every curve and draws the casters into those of a map, in the map's order.
    pub(super) fn raster_order(&self, commands: &mut Commands, map: u32, path: &RasterOrder) {
        let push = [map, path.drawn.first(map)];
        let unshadowed = if self.constants[1] == 1 { 0.0 } else { 1.0 };
        commands.pass("avsm.raster_order", |pass| {
            pass.render_ordered(&path.attachments, [EMPTY, unshadowed, EMPTY, unshadowed], |draw| {
                let sets = [path.drawn.bindings(), path.attachments.inputs()];
                path.drawn.draw(draw, &path.insert, &sets, bytemuck::bytes_of(&push), map);
            });
        });
    }

    /// Raster order: moves the curves of a map into `nodes`, which the look-up reads.
    pub(super) fn unpack(&self, commands: &mut Commands, map: u32, path: &RasterOrder) {
        commands.pass("avsm.unpack", |pass| {
            let groups = [self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1];
            pass.dispatch(&path.unpack, &[&self.nodes_bindings, &path.curves], bytemuck::bytes_of(&map), groups);
        });
    }
}
