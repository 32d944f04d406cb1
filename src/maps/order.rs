//! The casters of each map in the order of rising depth of their nearest points: a radix sort on the device, for passes
//! that draw in that order. Twin: [`crate::reference::twin::order`].

use super::Maps;
use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, Memory, groups, push_struct};
use crate::shaders::order::{COUNT, KEYS, SCAN, SCATTER};
use crate::shaders::set;
use crate::world::World;
use bytemuck::{Pod, Zeroable};

push_struct! {
    /// Twin: KeysPush in glsl/maps/order/keys.comp.
    struct KeysPush {
        count: u32,
        /// Places in each map's list.
        capacity: u32,
    }
}

push_struct! {
    /// Twin: SortPush in glsl/maps/order/sort.glsl.
    struct SortPush {
        /// Items per map.
        count: u32,
        /// Room per map, items.
        capacity: u32,
        maps: u32,
        /// The digit of the key to sort by, from the lowest.
        round: u32,
    }
}

/// Twin: BLOCK in glsl/maps/order/sort.glsl.
const BLOCK: u64 = 1024;

/// Twin: DIGITS.
const DIGITS: u64 = 256;

/// Rounds of the sort: each sorts by eight bits of the key.
const ROUNDS: u32 = 4;

/// Twin: Item in glsl/maps/order/sort.glsl and keys.comp.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ItemData {
    /// The sort key.
    pub key: u32,
    /// The caster's index.
    pub index: u32,
}

/// Keys, the sort and its result.
pub struct Order {
    /// Caster indices: map m's from `m · capacity` on.
    pub sorted: Buffer,
    /// [`ItemData`], in two halves: a round reads one half and writes the other.
    pub items: Buffer,
    counts: Buffer,
    capacity: u32,
    maps: u32,
    keys: Kernel<KeysPush>,
    count: Kernel<SortPush>,
    scan: Kernel<SortPush>,
    scatter: Kernel<SortPush>,
}

impl Order {
    /// Room for all casters of `world` in each of `maps`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, maps: &Maps) -> Result<Self> {
        let capacity = world.caster_capacity().max(1);
        let all = u64::from(capacity) * u64::from(maps.count());
        let buffer = |name, words: u64| Buffer::new(context, name, 4 * words, Memory::Device);
        let sorted = buffer("order.sorted", all)?;
        let items = buffer("order.items", 2 * all * size_of::<ItemData>() as u64 / 4)?;
        let counts = buffer("order.counts", u64::from(capacity).div_ceil(BLOCK) * DIGITS * u64::from(maps.count()))?;
        let first = set::OrderKeys { items: &items }.bind(context, "order.keys")?;
        let set = set::Order { items: &items, counts: &counts, sorted: &sorted }.bind(context, "order")?;
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &Constants::new());
        Ok(Self {
            keys: Kernel::compute(context, &KEYS, &[maps.scene(), &first], &Constants::new())?,
            count: kernel(&COUNT)?,
            scan: kernel(&SCAN)?,
            scatter: kernel(&SCATTER)?,
            sorted,
            items,
            counts,
            capacity,
            maps: maps.count(),
        })
    }

    /// Sorts the present casters, in maps that are already fitted.
    pub fn record(&self, commands: &mut Commands, world: &World) {
        let count = world.caster_count();
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = KeysPush { count, capacity: self.capacity };
        commands.pass("order.keys", |pass| pass.dispatch(&self.keys, &push, [x, y, self.maps]));
        self.sort(commands, count);
    }

    /// Sorts the first `count` items of each map by the keys in the items.
    pub fn sort(&self, commands: &mut Commands, count: u32) {
        let [x, y] = groups(u64::from(count).div_ceil(BLOCK));
        for round in 0..ROUNDS {
            let push = SortPush { count, capacity: self.capacity, maps: self.maps, round };
            commands.pass("order.count", |pass| pass.dispatch(&self.count, &push, [x, y, self.maps]));
            commands.pass("order.scan", |pass| pass.dispatch(&self.scan, &push, [1, 1, self.maps]));
            commands.pass("order.scatter", |pass| pass.dispatch(&self.scatter, &push, [x, y, self.maps]));
        }
    }

    /// Bytes of all buffers. They are needed only for the sort.
    pub fn bytes(&self) -> u64 {
        self.sorted.bytes() + self.items.bytes() + self.counts.bytes()
    }
}
