//! A radix sort on the device, for passes that draw casters in an order; and one such order: the casters of each map by rising depth of
//! their nearest points. Twin: [`crate::reference::twin::order`].

use super::Maps;
use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Context, Features, Kernel, Memory, Pass, groups, push_struct};
use crate::shaders::constant::{COUNTED, SERIAL, SORT_BLOCK};
use crate::shaders::order::{COUNT, KEYS, SCAN, SCATTER_BALLOTS_0, SCATTER_BALLOTS_1};
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
        /// Items per list, or the most that there may be.
        count: u32,
        /// Room per list, items.
        capacity: u32,
        lists: u32,
        /// The digit of the key to sort by, from the lowest.
        round: u32,
    }
}

/// Items per workgroup. With few of them a long list has fewer items that wait for each other; with many, there are fewer counts to add up.
const BLOCKS: [u32; 2] = [512, 2048];

/// From this room on, workgroups take many items.
const MANY_ITEMS: u32 = 1 << 18;

/// Twin: DIGITS.
const DIGITS: u32 = 256;

/// Bits of the key by which a round sorts.
const DIGIT_BITS: u32 = 8;

/// Blocks of which one thread per digit adds up the counts. For more of them there is a workgroup per digit.
const FEW_BLOCKS: u32 = 16;

/// Twin: SORT_THREADS.
const THREADS: u32 = 128;

/// How a workgroup finds how many earlier items of its block have the same digit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ranking {
    /// One thread moves all items: faster where threads do not run at the same time anyway.
    Serial,
    /// Each thread looks at the digits of all others, in shared memory.
    Shared,
    /// By ballots of full subgroups.
    Ballots,
}

impl Ranking {
    /// The fastest on the device.
    fn best(features: &Features) -> Self {
        match features.is_software() {
            true => Self::Serial,
            false if features.lacks_full_subgroups(THREADS).is_some() => Self::Shared,
            false => Self::Ballots,
        }
    }
}

/// Twin: Item in glsl/maps/order/sort.glsl and keys.comp.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ItemData {
    /// The sort key.
    pub key: u32,
    /// The caster's index.
    pub index: u32,
}

const ITEM_BYTES: u64 = size_of::<ItemData>() as u64;

/// The sort of one or several lists, and its result.
pub struct Order {
    /// Indices: list l's from `l · capacity` on.
    pub sorted: Buffer,
    /// [`ItemData`], in two halves: a round reads one half and writes the other. Keys are written into the first.
    pub items: Buffer,
    passes: Passes,
}

/// The passes of a sort.
struct Passes {
    counts: Buffer,
    block: u32,
    capacity: u32,
    lists: u32,
    count: Kernel<SortPush>,
    scan: Kernel<SortPush>,
    scatter: Kernel<SortPush>,
}

impl Passes {
    /// For lists with room for `capacity` items each. `counted` begins with their number, where only the device knows it.
    fn new(
        context: &Context,
        [capacity, lists]: [u32; 2],
        items: &Buffer,
        sorted: Option<&Buffer>,
        counted: Option<&Buffer>,
        ranking: Ranking,
    ) -> Result<Self> {
        let block = BLOCKS[usize::from(capacity >= MANY_ITEMS)];
        let words = u64::from(capacity.div_ceil(block) + 1) * u64::from(DIGITS) * u64::from(lists);
        let counts = Buffer::new(context, "order.counts", 4 * words, Memory::Device)?;
        // What is not used stays bound to something.
        let (sorted, number) = (sorted.unwrap_or(&counts), counted.unwrap_or(&counts));
        let set = set::Order { items, counts: &counts, sorted, counted: number }.bind(context, "order")?;
        let constants = Constants::new()
            .set(COUNTED, counted.is_some())
            .set(SERIAL, ranking == Ranking::Serial)
            .set(SORT_BLOCK, block);
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &constants);
        Ok(Self {
            count: kernel(&COUNT)?,
            scan: kernel(&SCAN)?,
            scatter: match ranking {
                Ranking::Ballots => Kernel::full_subgroups(context, &SCATTER_BALLOTS_1, &[&set], &constants)?,
                _ => kernel(&SCATTER_BALLOTS_0)?,
            },
            counts,
            block,
            capacity,
            lists,
        })
    }

    /// Records `rounds` rounds for at most `count` items. `blocks` dispatches a kernel over the blocks.
    fn record(
        &self,
        commands: &mut Commands,
        [count, rounds]: [u32; 2],
        blocks: impl Fn(&mut Pass, &Kernel<SortPush>, &SortPush),
    ) {
        let scans = if count.div_ceil(self.block) <= FEW_BLOCKS { DIGITS / THREADS } else { DIGITS };
        for round in 0..rounds {
            let push = SortPush { count, capacity: self.capacity, lists: self.lists, round };
            commands.pass("order.count", |pass| blocks(pass, &self.count, &push));
            commands.pass("order.scan", |pass| pass.dispatch(&self.scan, &push, [scans, 1, self.lists]));
            commands.pass("order.scatter", |pass| blocks(pass, &self.scatter, &push));
        }
    }
}

impl Order {
    /// Room for `capacity` items in each of `lists` lists.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, capacity: u32, lists: u32) -> Result<Self> {
        Self::ranked(context, capacity, lists, Ranking::best(context.features()))
    }

    /// As [`Order::new`], by the given ranking, which the device must be able to do.
    ///
    /// # Errors
    /// As [`Order::new`].
    pub fn ranked(context: &Context, capacity: u32, lists: u32, ranking: Ranking) -> Result<Self> {
        let capacity = capacity.max(1);
        let all = u64::from(capacity) * u64::from(lists);
        let sorted = Buffer::new(context, "order.sorted", 4 * all, Memory::Device)?;
        let items = Buffer::new(context, "order.items", 2 * all * ITEM_BYTES, Memory::Device)?;
        let passes = Passes::new(context, [capacity, lists], &items, Some(&sorted), None, ranking)?;
        Ok(Self { sorted, items, passes })
    }

    /// Sorts the first `count` items of each list by the keys in the items. Items with equal keys keep their order.
    pub fn sort(&self, commands: &mut Commands, count: u32) {
        let [x, y] = groups(u64::from(count.div_ceil(self.passes.block)));
        let lists = self.passes.lists;
        let blocks = |pass: &mut Pass, kernel: &Kernel<SortPush>, push: &SortPush| {
            pass.dispatch(kernel, push, [x, y, lists]);
        };
        self.passes.record(commands, [count, u32::BITS / DIGIT_BITS], blocks);
    }

    /// Bytes of all buffers. They are needed only for the sort.
    pub fn bytes(&self) -> u64 {
        self.sorted.bytes() + self.items.bytes() + self.passes.counts.bytes()
    }
}

/// The sort of one list whose length only the device knows, by keys of few bits. Items keep their keys.
pub struct CountedOrder {
    /// [`ItemData`], as in [`Order::items`].
    pub items: Buffer,
    passes: Passes,
    counted: Buffer,
    rounds: u32,
}

impl CountedOrder {
    /// Room for `capacity` items with keys below `keys`. `counted` begins with the number of items; behind it stands a
    /// VkDispatchIndirectCommand with a workgroup per [`CountedOrder::block`] of them.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, capacity: u32, keys: u32, counted: &Buffer) -> Result<Self> {
        let items = Buffer::new(context, "order.items", 2 * u64::from(capacity) * ITEM_BYTES, Memory::Device)?;
        let ranking = Ranking::best(context.features());
        let passes = Passes::new(context, [capacity, 1], &items, None, Some(counted), ranking)?;
        let bits = u32::BITS - keys.saturating_sub(1).leading_zeros();
        Ok(Self { items, passes, counted: counted.clone(), rounds: bits.div_ceil(DIGIT_BITS).max(1) })
    }

    /// Items per workgroup.
    pub fn block(&self) -> u32 {
        self.passes.block
    }

    /// The place of the first sorted item.
    pub fn first(&self) -> u32 {
        self.rounds % 2 * self.passes.capacity
    }

    /// Items that there is room for.
    pub fn capacity(&self) -> u32 {
        self.passes.capacity
    }

    /// Sorts the items by their keys. Items with equal keys keep their order.
    pub fn sort(&self, commands: &mut Commands) {
        self.passes.record(commands, [self.passes.capacity, self.rounds], |pass, kernel, push| {
            pass.dispatch_indirect(kernel, push, &self.counted, 4);
        });
    }

    /// Bytes of all buffers.
    pub fn bytes(&self) -> u64 {
        self.items.bytes() + self.passes.counts.bytes()
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
        let (count, Passes { capacity, lists, .. }) = (world.caster_count(), &self.order.passes);
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = KeysPush { count, capacity: *capacity };
        commands.pass("order.keys", |pass| pass.dispatch(&self.keys, &push, [x, y, *lists]));
        self.order.sort(commands, count);
    }
}
