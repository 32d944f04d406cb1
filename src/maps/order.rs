//! A radix sort on the device, for passes that draw casters in some order, and one such order: the casters of each map by increasing depth
//! of their nearest points. Twin: [`crate::reference::twin::order`].

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
        /// Capacity of each map's list.
        capacity: u32,
    }
}

push_struct! {
    /// Twin: SortPush in glsl/maps/order/sort.glsl.
    struct SortPush {
        /// Number of items per list, or the maximum if only the device knows it.
        count: u32,
        /// Capacity of each list, in items.
        capacity: u32,
        lists: u32,
        /// Digit of the key to sort by, counted from the lowest.
        round: u32,
    }
}

/// Items per workgroup. With small blocks, fewer items of a long list wait for each other; with large blocks, there are fewer counts to add
/// up.
const BLOCKS: [u32; 2] = [512, 2048];

/// Capacity from which workgroups process large blocks.
const MANY_ITEMS: u32 = 1 << 18;

/// Twin: DIGITS.
const DIGITS: u32 = 256;

/// Bits of the key that one round sorts by.
const DIGIT_BITS: u32 = 8;

/// Maximum number of blocks whose counts are added up by one thread per digit. For more blocks, there is one workgroup
/// per digit.
const FEW_BLOCKS: u32 = 16;

/// Twin: SORT_THREADS.
const THREADS: u32 = 128;

/// How a workgroup finds how many earlier items of its block have the same digit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ranking {
    /// One thread moves all items: faster on devices whose threads do not run in parallel anyway.
    Serial,
    /// Each thread looks at the digits of all other threads, in shared memory.
    Shared,
    /// By ballots of full subgroups.
    Ballots,
}

impl Ranking {
    /// Returns the fastest ranking on the device.
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

/// The sort of one or more lists, and its result.
pub struct Order {
    /// Indices; list l begins at `l · capacity`.
    pub sorted: Buffer,
    /// [`ItemData`], in two halves: each round reads one half and writes the other. Keys are written to the first half.
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
    /// Creates the passes for lists of `capacity` items each. `counted` begins with the number of items, if only the device knows it.
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
        // Unused bindings still need a buffer.
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
    /// Allocates `lists` lists of `capacity` items each.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, capacity: u32, lists: u32) -> Result<Self> {
        Self::ranked(context, capacity, lists, Ranking::best(context.features()))
    }

    /// Same as [`Order::new`], but with the given ranking, which the device must support.
    ///
    /// # Errors
    /// Same as [`Order::new`].
    pub fn ranked(context: &Context, capacity: u32, lists: u32, ranking: Ranking) -> Result<Self> {
        let capacity = capacity.max(1);
        let all = u64::from(capacity) * u64::from(lists);
        let sorted = Buffer::new(context, "order.sorted", 4 * all, Memory::Device)?;
        let items = Buffer::new(context, "order.items", 2 * all * ITEM_BYTES, Memory::Device)?;
        let passes = Passes::new(context, [capacity, lists], &items, Some(&sorted), None, ranking)?;
        Ok(Self { sorted, items, passes })
    }

    /// Sorts the first `count` items of each list by their keys. Items with equal keys keep their order.
    pub fn sort(&self, commands: &mut Commands, count: u32) {
        let [x, y] = groups(u64::from(count.div_ceil(self.passes.block)));
        let lists = self.passes.lists;
        let blocks = |pass: &mut Pass, kernel: &Kernel<SortPush>, push: &SortPush| {
            pass.dispatch(kernel, push, [x, y, lists]);
        };
        self.passes.record(commands, [count, u32::BITS / DIGIT_BITS], blocks);
    }

    /// Returns the size of all buffers in bytes. They are needed only for the sort.
    pub fn bytes(&self) -> u64 {
        self.sorted.bytes() + self.items.bytes() + self.passes.counts.bytes()
    }
}

/// The sort of one list whose length only the device knows, by keys with few bits. Items keep their keys.
pub struct CountedOrder {
    /// [`ItemData`], as in [`Order::items`].
    pub items: Buffer,
    passes: Passes,
    counted: Buffer,
    rounds: u32,
}

impl CountedOrder {
    /// Allocates `capacity` items with keys below `keys`. `counted` begins with the number of items, followed by a
    /// VkDispatchIndirectCommand with one workgroup per [`CountedOrder::block`] items.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, capacity: u32, keys: u32, counted: &Buffer) -> Result<Self> {
        let items = Buffer::new(context, "order.items", 2 * u64::from(capacity) * ITEM_BYTES, Memory::Device)?;
        let ranking = Ranking::best(context.features());
        let passes = Passes::new(context, [capacity, 1], &items, None, Some(counted), ranking)?;
        let bits = u32::BITS - keys.saturating_sub(1).leading_zeros();
        Ok(Self { items, passes, counted: counted.clone(), rounds: bits.div_ceil(DIGIT_BITS).max(1) })
    }

    /// Returns the number of items per workgroup.
    pub fn block(&self) -> u32 {
        self.passes.block
    }

    /// Returns the position of the first sorted item.
    pub fn first(&self) -> u32 {
        self.rounds % 2 * self.passes.capacity
    }

    /// Returns the capacity, in items.
    pub fn capacity(&self) -> u32 {
        self.passes.capacity
    }

    /// Sorts the items by their keys. Items with equal keys keep their order.
    pub fn sort(&self, commands: &mut Commands) {
        self.passes.record(commands, [self.passes.capacity, self.rounds], |pass, kernel, push| {
            pass.dispatch_indirect(kernel, push, &self.counted, 4);
        });
    }

    /// Returns the size of all buffers, in bytes.
    pub fn bytes(&self) -> u64 {
        self.items.bytes() + self.passes.counts.bytes()
    }
}

/// The casters of each map by increasing depth of their nearest points.
pub struct NearToFar {
    /// One list per map.
    pub order: Order,
    keys: Kernel<KeysPush>,
}

impl NearToFar {
    /// Allocates lists for all casters of `world` in each of `maps`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, maps: &Maps) -> Result<Self> {
        let order = Order::new(context, world.caster_capacity(), maps.count())?;
        let first = set::OrderKeys { items: &order.items }.bind(context, "order.keys")?;
        let keys = Kernel::compute(context, &KEYS, &[maps.scene(), &first], &Constants::new())?;
        Ok(Self { order, keys })
    }

    /// Sorts the current casters, in maps that are already fitted.
    pub fn record(&self, commands: &mut Commands, world: &World) {
        let (count, Passes { capacity, lists, .. }) = (world.caster_count(), &self.order.passes);
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = KeysPush { count, capacity: *capacity };
        commands.pass("order.keys", |pass| pass.dispatch(&self.keys, &push, [x, y, *lists]));
        self.order.sort(commands, count);
    }
}
