//! Draws the casters as quads over the maps, in order. Casters that meet no tile, according to the bins, are skipped.

use super::{Bins, Compact, Maps, NearToFar};
use crate::Result;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Constants, Context, Draw, Format, Graphics, Kernel, Shader, push_struct,
};
use crate::maps::bins::compact::COMMAND_BYTES;
use crate::shaders;
use crate::shaders::set;
use crate::world::World;
use std::ops::Range;

push_struct! {
    /// Twin: QuadsPush in glsl/maps/caster_quads.glsl.
    pub struct QuadsPush {
        /// Index of the map over all lights.
        map: u32,
        /// Index at which the map's drawing order begins.
        order_first: u32,
        /// Position of the map among the maps that are drawn together.
        slot: u32,
        /// Index of the group of maps that are drawn together.
        group: u32,
        /// Capacity of the lists that are drawn into, if any.
        capacity: u32,
    }
}

/// The order in which casters are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawingOrder {
    /// By index.
    Index,
    /// By increasing depth of their nearest points in each map's view; ties by index.
    NearToFar,
}

/// The draws of each map's casters, with their arguments.
pub struct CasterQuads {
    /// The sort; `None` if casters are drawn by index.
    order: Option<NearToFar>,
    set: Bindings,
    /// The casters that remain after culling.
    culled: Option<Compact>,
    /// Capacity of each drawing order: map m's order begins at `m · capacity`.
    capacity: u32,
    caster_count: u32,
    size: [u32; 2],
    /// See [`World::constants`].
    kinds: Constants,
}

impl CasterQuads {
    /// Prepares draws of all casters in the given order, except those that `bins` culls, if there are bins.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        sorting: DrawingOrder,
        bins: Option<&Bins>,
    ) -> Result<Self> {
        let capacity = world.caster_capacity().max(1);
        let (sorts, order) = match sorting {
            DrawingOrder::Index => {
                let indices: Vec<u32> = (0..maps.count()).flat_map(|_| 0..capacity).collect();
                (None, Buffer::with_data(context, "quads.order", &indices)?)
            }
            DrawingOrder::NearToFar => {
                let near_to_far = NearToFar::new(context, world, maps)?;
                let sorted = near_to_far.order.sorted.clone();
                (Some(near_to_far), sorted)
            }
        };
        let culled = match bins {
            None => None,
            Some(bins) => Some(Compact::new(context, bins.met(), &order, capacity, maps.count())?),
        };
        let drawn = culled.as_ref().map_or(&order, |c| &c.drawn).clone();
        let set = set::CasterQuads { order: &drawn }.bind(context, "quads")?;
        let (caster_count, kinds) = (world.caster_count(), world.constants());
        Ok(Self { order: sorts, set, culled, capacity, caster_count, size: maps.size(), kinds })
    }

    /// Prepares draws of all casters in an order that the caller sorts.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn sorted_by(context: &Context, world: &World, maps: &Maps, order: &Buffer) -> Result<Self> {
        let set = set::CasterQuads { order }.bind(context, "quads")?;
        let capacity = world.caster_capacity().max(1);
        let (caster_count, kinds) = (world.caster_count(), world.constants());
        Ok(Self { order: None, set, culled: None, capacity, caster_count, size: maps.size(), kinds })
    }

    /// Creates a kernel that draws casters with a fragment shader into color targets. Set 0 holds the maps, set 1 the
    /// order, and `more` follows from set 2 on.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the driver rejects the shader.
    pub fn kernel(
        &self,
        context: &Context,
        maps: &Maps,
        fragment: &Shader,
        colors: &[(Format, Blend)],
        more: &[&Bindings],
        constants: &Constants,
    ) -> Result<Kernel<QuadsPush>> {
        let constants = maps.colored(constants).and(&self.kinds);
        let state = Graphics { vertex: &shaders::maps::CASTER_QUADS_VERT, fragment, colors, depth: None };
        let sets: Vec<_> = [maps.scene(), &self.set].into_iter().chain(more.iter().copied()).collect();
        Kernel::graphics(context, &state, &sets, &constants)
    }

    /// Returns the set with the drawing orders.
    pub fn set(&self) -> &Bindings {
        &self.set
    }

    /// Sorts the casters again if the maps have moved, and gathers the casters that `bins` has not culled. Records no
    /// pass if there is nothing to do.
    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps, bins: Option<&Bins>) {
        self.caster_count = world.caster_count();
        if let (Some(order), true) = (&self.order, maps.moved()) {
            order.record(commands, world);
        }
        if let (Some(culled), Some(_)) = (&self.culled, bins) {
            culled.record(commands, self.caster_count);
        }
    }

    /// Draws the casters of each map in `maps`, which form group `group`. The maps are stacked.
    pub fn draw(&self, draw: &mut Draw, kernel: &Kernel<QuadsPush>, maps: Range<u32>, group: u32, capacity: u32) {
        for (slot, map) in (0..).zip(maps) {
            let push = QuadsPush { map, order_first: map * self.capacity, slot, group, capacity };
            draw.rows(slot * self.size[1], self.size);
            match &self.culled {
                None => draw.draw(kernel, &push, 6 * self.caster_count, 1),
                Some(culled) => draw.draw_indirect(kernel, &push, &culled.draws, u64::from(map) * COMMAND_BYTES),
            }
        }
    }

    /// Draws the casters at `places` in the first map's order.
    pub fn draw_places(&self, draw: &mut Draw, kernel: &Kernel<QuadsPush>, places: Range<u32>) {
        let push = QuadsPush { map: 0, order_first: 0, slot: 0, group: 0, capacity: 0 };
        draw.draw_part(kernel, &push, 6 * places.start..6 * places.end);
    }

    /// Returns the size of the orders and the commands, in bytes.
    pub fn bytes(&self) -> u64 {
        self.culled.as_ref().map_or(0, Compact::bytes) + self.order.as_ref().map_or(0, |sorts| sorts.order.bytes())
    }
}
