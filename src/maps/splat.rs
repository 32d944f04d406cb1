//! The casters drawn as quads over the maps, in order; those that the bins found to meet no tile are left out.

use super::{Bins, Map, Maps};
use crate::Result;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Constants, Context, Draw, Format, Graphics, Kernel, Memory, Resource, Shader,
    push_struct,
};
use crate::scene::near_to_far;
use crate::shaders;
use crate::world::World;
use std::ops::Range;

/// Bytes of a draw's command: vertices, instances, first vertex, first instance.
const COMMAND_BYTES: u64 = 16;

push_struct! {
    /// Twin: SplatPush in glsl/maps/splat.glsl.
    pub struct SplatPush {
        /// Of all lights' maps.
        map: u32,
        /// Where its drawing order begins.
        order_first: u32,
        /// Its place among the maps that are drawn at once.
        slot: u32,
        /// Which of the groups of maps that are drawn at once.
        group: u32,
        /// Of the lists that are drawn into, if any.
        capacity: u32,
    }
}

push_struct! {
    /// Twin: CompactPush in glsl/bins/compact.comp.
    struct CompactPush { caster_count: u32 }
}

/// The order in which casters are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawingOrder {
    /// By index.
    Index,
    /// By rising depth of their nearest points in each map's view; ties by index.
    NearToFar,
}

/// What is drawn of each map.
pub struct Splat {
    sorting: DrawingOrder,
    /// Of the world whose order stands.
    generation: u64,
    order: Buffer,
    set: Bindings,
    culled: Option<Culled>,
    /// Between the orders of two maps.
    capacity: u32,
    caster_count: u32,
    size: [u32; 2],
}

/// Where the casters that are left stand.
struct Culled {
    drawn: Buffer,
    draws: Buffer,
    compact: Kernel<CompactPush>,
}

impl Splat {
    /// All casters in that order; without those that `bins` culls, if there are bins.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        sorting: DrawingOrder,
        bins: Option<&Bins>,
    ) -> Result<Self> {
        let capacity = world.caster_capacity();
        let order = Buffer::with_data(context, "splat.order", &orders(world, maps.all(), sorting, capacity))?;
        let culled = match bins {
            None => None,
            Some(bins) => {
                let drawn = Buffer::new(context, "splat.casters", order.bytes(), Memory::Device)?;
                let bytes = COMMAND_BYTES * u64::from(maps.count());
                let draws = Buffer::new(context, "splat.draws", bytes, Memory::Device)?;
                let resources = [&order, &drawn, &draws].map(|b| Resource::Buffer(b.clone()));
                let set = Bindings::new(context, "splat.compact", &resources)?;
                let sets = [bins.set(), &set];
                let compact = Kernel::compute(context, &shaders::bins::COMPACT, &sets, &Constants::new())?;
                Some(Culled { drawn, draws, compact })
            }
        };
        let drawn = culled.as_ref().map_or(&order, |c| &c.drawn).clone();
        let set = Bindings::new(context, "splat", &[Resource::Buffer(drawn)])?;
        let caster_count = world.caster_count();
        Ok(Self {
            sorting,
            generation: world.generation(),
            order,
            set,
            culled,
            capacity,
            caster_count,
            size: maps.size(),
        })
    }

    /// What draws casters with a fragment shader into colour targets: sets 0 and 1 are the maps' and the order, set 2 is
    /// `more`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects the shader.
    pub fn kernel(
        &self,
        context: &Context,
        maps: &Maps,
        fragment: &Shader,
        colors: &[(Format, Blend)],
        more: &[&Bindings],
        constants: &Constants,
    ) -> Result<Kernel<SplatPush>> {
        let state = Graphics { vertex: &shaders::maps::SPLAT_VERT, fragment, colors, depth: false };
        let sets: Vec<_> = [maps.scene(), &self.set].into_iter().chain(more.iter().copied()).collect();
        Kernel::graphics(context, &state, &sets, constants)
    }

    /// The set of the drawing orders.
    pub fn set(&self) -> &Bindings {
        &self.set
    }

    /// Brings the orders up to date where the world has moved, and gathers the casters that `bins` has counted. No pass
    /// where there is nothing to do.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) -> Result<()> {
        if self.generation != world.generation() {
            self.generation = world.generation();
            self.caster_count = world.caster_count();
            let orders = orders(world, maps.all(), self.sorting, self.capacity);
            commands.upload("splat.order", &self.order, &orders)?;
        }
        if let (Some(culled), Some(_)) = (&self.culled, bins) {
            commands.pass("bins.compact", |pass| {
                let push = CompactPush { caster_count: self.caster_count };
                pass.dispatch(&culled.compact, &push, [1, 1, maps.count()]);
            });
        }
        Ok(())
    }

    /// Draws the casters of each map of `maps`, group number `group`, one map above the other.
    pub fn draw(&self, draw: &mut Draw, kernel: &Kernel<SplatPush>, maps: Range<u32>, group: u32, capacity: u32) {
        for (slot, map) in (0..).zip(maps) {
            let push = SplatPush { map, order_first: map * self.caster_count, slot, group, capacity };
            draw.rows(slot * self.size[1], self.size);
            match &self.culled {
                None => draw.draw(kernel, &push, 6 * self.caster_count, 1),
                Some(culled) => draw.draw_indirect(kernel, &push, &culled.draws, u64::from(map) * COMMAND_BYTES),
            }
        }
    }

    /// Bytes of the order that is left and the commands.
    pub fn bytes(&self) -> u64 {
        self.culled.as_ref().map_or(0, |c| c.drawn.bytes() + c.draws.bytes())
    }
}

/// The orders of all maps, one after the other.
fn orders(world: &World, maps: &[Map], sorting: DrawingOrder, capacity: u32) -> Vec<u32> {
    let order = |map: &Map| match sorting {
        DrawingOrder::Index => (0..world.caster_count()).collect(),
        DrawingOrder::NearToFar => near_to_far(world.scene(), &map.volume),
    };
    let mut all: Vec<u32> = maps.iter().flat_map(order).collect();
    all.resize(maps.len() * capacity as usize, 0);
    all
}
