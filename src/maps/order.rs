//! A radix sort on the device, for passes that draw casters in an order; and one such order: the casters of each map by rising depth of
//! their nearest points. Twin: [`crate::reference::twin::order`].

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

/// The sort of one or several lists, and its result.
pub struct Order {
    /// Indices: list l's from `l · capacity` on.
    pub sorted: Buffer,
    /// [`ItemData`], in two halves: a round reads one half and writes the other. Keys are written into the first.
    pub items: Buffer,
    counts: Buffer,
    capacity: u32,
    lists: u32,
    count: Kernel<SortPush>,
    scan: Kernel<SortPush>,
    scatter: Kernel<SortPush>,
}

impl Order {
    /// Room for `capacity` items in each of `lists` lists.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, capacity: u32, lists: u32) -> Result<Self> {
        let capacity = capacity.max(1);
        let all = u64::from(capacity) * u64::from(lists);
        let buffer = |name, words: u64| Buffer::new(context, name, 4 * words, Memory::Device);
        let sorted = buffer("order.sorted", all)?;
        let items = buffer("order.items", 2 * all * size_of::<ItemData>() as u64 / 4)?;
        let counts = buffer("order.counts", u64::from(capacity).div_ceil(BLOCK) * DIGITS * u64::from(lists))?;
        let set = set::Order { items: &items, counts: &counts, sorted: &sorted }.bind(context, "order")?;
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &Constants::new());
        Ok(Self {
            count: kernel(&COUNT)?,
            scan: kernel(&SCAN)?,
            scatter: kernel(&SCATTER)?,
            sorted,
            items,
            counts,
            capacity,
            lists,
        })
    }

    /// Sorts the first `count` items of each list by the keys in the items. Items with equal keys keep their order.
    pub fn sort(&self, commands: &mut Commands, count: u32) {
        let [x, y] = groups(u64::from(count).div_ceil(BLOCK));
        for round in 0..ROUNDS {
            let push = SortPush { count, capacity: self.capacity, maps: self.lists, round };
            commands.pass("order.count", |pass| pass.dispatch(&self.count, &push, [x, y, self.lists]));
            commands.pass("order.scan", |pass| pass.dispatch(&self.scan, &push, [1, 1, self.lists]));
            commands.pass("order.scatter", |pass| pass.dispatch(&self.scatter, &push, [x, y, self.lists]));
        }
    }

    /// Bytes of all buffers. They are needed only for the sort.
    pub fn bytes(&self) -> u64 {
        self.sorted.bytes() + self.items.bytes() + self.counts.bytes()
    }
}

/// The casters of each map by rising depth of their nearest points.
pub struct NearToFar {
    /// A list per map.
    pub order: Order,
    keys: Kernel<KeysPush>,
}

impl NearToFar {
    /// Room for all casters of `world` in each of `maps`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, maps: &Maps) -> Result<Self> {
        let order = Order::new(context, world.caster_capacity(), maps.count())?;
        let first = set::OrderKeys { items: &order.items }.bind(context, "order.keys")?;
        let keys = Kernel::compute(context, &KEYS, &[maps.scene(), &first], &Constants::new())?;
        Ok(Self { order, keys })
    }

    /// Sorts the present casters, in maps that are already fitted.
    pub fn record(&self, commands: &mut Commands, world: &World) {
        let (count, Order { capacity, lists, .. }) = (world.caster_count(), &self.order);
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = KeysPush { count, capacity: *capacity };
        commands.pass("order.keys", |pass| pass.dispatch(&self.keys, &push, [x, y, *lists]));
        self.order.sort(commands, count);
    }
}
