//! The casters that a rasterizing path draws, in order; those that [`super::bins`] found to meet no tile are left out.

use super::SceneData;
use super::bins::Bins;
use super::light::Maps;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context, Draw, Memory, Pipeline, Resource, shader};

/// Bytes of a draw's command: vertices, instances, first vertex, first instance.
const COMMAND_BYTES: u64 = 16;

/// What is drawn of each map.
pub struct Drawn {
    scene: Bindings,
    culled: Option<Culled>,
    caster_count: u32,
}

/// Where the casters that are left stand.
struct Culled {
    drawn: Buffer,
    draws: Buffer,
    bindings: Bindings,
    compact: Pipeline,
}

impl Drawn {
    /// All casters in the order of `orders`, map after map; without those that `bins` culls, if there are bins.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &SceneData, maps: &Maps, orders: &[u32], bins: Option<&Bins>) -> Result<Self> {
        let order = Buffer::with_data(context, "drawn.order", orders)?;
        let culled = match bins {
            None => None,
            Some(bins) => {
                let drawn = Buffer::new(context, "drawn.casters", order.bytes(), Memory::Device)?;
                let bytes = COMMAND_BYTES * u64::from(maps.count());
                let draws = Buffer::new(context, "drawn.draws", bytes, Memory::Device)?;
                let resources = [&order, &drawn, &draws].map(|b| Resource::Buffer(b.clone()));
                let bindings = Bindings::new(context, "drawn.compact", &resources)?;
                let sets = [bins.bindings(), &bindings];
                let compact = Pipeline::compute(context, shader("bins/compact.comp")?, &sets, &[])?;
                Some(Culled { drawn, draws, bindings, compact })
            }
        };
        let drawn = culled.as_ref().map_or(&order, |c| &c.drawn);
        let resources = [&maps.buffer, &scene.casters, drawn].map(|b| Resource::Buffer(b.clone()));
        let scene_bindings = Bindings::new(context, "drawn.scene", &resources)?;
        Ok(Self { scene: scene_bindings, culled, caster_count: scene.caster_count })
    }

    /// The set that glsl/list/caster.vert reads: maps, casters, drawing orders.
    pub fn bindings(&self) -> &Bindings {
        &self.scene
    }

    /// Where the drawing order of map `map` begins.
    pub fn first(&self, map: u32) -> u32 {
        map * self.caster_count
    }

    /// Gathers the casters of a map that `bins` has counted. No pass without bins.
    pub fn compact(&self, commands: &mut Commands, map: u32, bins: Option<&Bins>) {
        if let (Some(culled), Some(bins)) = (&self.culled, bins) {
            commands.pass("bins.compact", |pass| {
                let push = [map, self.caster_count];
                let sets = [bins.bindings(), &culled.bindings];
                pass.dispatch(&culled.compact, &sets, bytemuck::bytes_of(&push), [1, 1, 1]);
            });
        }
    }

    /// Draws the casters of a map, six vertices each.
    pub fn draw(&self, draw: &mut Draw, pipeline: &Pipeline, sets: &[&Bindings], push: &[u8], map: u32) {
        match &self.culled {
            None => draw.draw(pipeline, sets, push, 6 * self.caster_count),
            Some(culled) => {
                draw.draw_indirect(pipeline, sets, push, &culled.draws, u64::from(map) * COMMAND_BYTES);
            }
        }
    }

    /// Bytes of the order that is left and the commands.
    pub fn bytes(&self) -> u64 {
        self.culled.as_ref().map_or(0, |c| c.drawn.bytes() + c.draws.bytes())
    }
}
