//! Lists of the triangles or casters that overlap each voxel.

use super::{GridPush, LARGE_GROUPS, LISTS_BYTES, THREADS, grid_words, side};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, ReadBack, Shader, groups};
use crate::shaders::set;
use crate::shaders::{grid, lists as shaders};
use crate::world::World;
use crate::{Error, Less, Result, WayOut};
use bytemuck::{Pod, Zeroable};

/// Number of values that a workgroup sums. Twin: SCANNED in glsl/grid/lists/scan.glsl.
const SCANNED: u32 = 1024;

/// Number of words per used voxel, and per list entry. Twin: LIST_WORDS in glsl/grid/lists/place.glsl.
const LIST_WORDS: u64 = 2;

/// Size of a pair in bytes: a voxel's bit, a triangle or a caster, and its box in the voxel.
const PAIR_BYTES: u64 = 12;

/// Totals over all lists. Twin: ListTotals in glsl/grid/lists/set.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ListTotals {
    /// Number of pairs of a voxel and a triangle or caster that overlaps it.
    pub pairs: u32,
    /// Number of voxels overlapped by any triangle or caster. The device counts one more: the voxel of the list shared by all voxels.
    pub voxels: u32,
    /// 1 if the number of pairs exceeds 32 bits.
    pub overflowed: u32,
}

impl ListTotals {
    /// Returns the number of words in the lists, including the words of `bricks` bricks.
    fn words(self, bricks: u32) -> u64 {
        u64::from(bricks) + 1 + LIST_WORDS * (u64::from(self.voxels) + 1 + u64::from(self.pairs))
    }
}

/// The kind of lists, and the names of its passes: clear, note, number, fill, find starts, rank, sort.
struct ListKind {
    what: &'static str,
    passes: [&'static str; 7],
}

const TRIANGLES: ListKind = ListKind {
    what: "triangles",
    passes: ["grid.clear_lists", "grid.pairs", "grid.number", "grid.fill", "grid.starts", "grid.rank", "grid.sort"],
};

const CASTERS: ListKind = ListKind {
    what: "casters",
    passes: [
        "grid.casters.clear",
        "grid.casters",
        "grid.casters.number",
        "grid.casters.fill",
        "grid.casters.starts",
        "grid.casters.rank",
        "grid.casters.sort",
    ],
};

/// The largest number of pairs for all casters together, if a buffer can hold that many: half a gigabyte of lists.
const MOST_PAIRS: u32 = 1 << 25;

/// The largest number of list bytes per pair: the pair's own words, and the words of a voxel that only this pair uses.
const LISTED_BYTES: u32 = 4 * 2 * LIST_WORDS as u32;

/// A caster whose box has at most this many voxels is always listed in each of them.
const LEAST_SHARE: u32 = 64;

/// Returns the largest number of voxels in a caster's box for which the caster is listed in each voxel that it overlaps. A caster with a
/// larger box is listed once, in the list shared by all voxels. The number is chosen so that a buffer on this device has room for the pairs
/// of `casters` casters.
pub fn caster_share(context: &Context, casters: u32) -> u32 {
    let pairs = (context.features().max_storage_buffer_range / LISTED_BYTES).min(MOST_PAIRS);
    (pairs / casters.max(1)).max(LEAST_SHARE)
}

/// The lists and the passes that build them. Their buffers grow as needed.
pub(super) struct Lists {
    context: Context,
    /// Number of bricks in the grid, plus one for the list shared by all voxels.
    bricks: u32,
    pairs: Buffer,
    /// The lists, in the layout of glsl/grid/lists/place.glsl.
    pub(super) words: Buffer,
    sums: Buffer,
    totals: Buffer,
    /// The lists before they are sorted.
    unsorted: Buffer,
    counted: ReadBack,
    /// The totals of the last build.
    pub(super) last: ListTotals,
    set: Bindings,
    listed: &'static ListKind,
    note: [Kernel<GridPush>; 3],
    number: [Kernel<GridPush>; 2],
    fill: [Kernel<GridPush>; 2],
    starts: [Kernel<GridPush>; 2],
    rank: Kernel<GridPush>,
    sort: Kernel<GridPush>,
}

/// Allocates buffers with room for `pairs` pairs, for `words` words of lists, for the words' prefix sums, and for unsorted triangles.
fn room(context: &Context, bricks: u32, pairs: u64, words: u64) -> Result<[Buffer; 4]> {
    let sums = u64::from(bricks).max(pairs).div_ceil(u64::from(SCANNED));
    Ok([
        Buffer::new(context, "grid.pairs", PAIR_BYTES * pairs, Memory::Device)?,
        Buffer::new(context, "grid.lists", 4 * words, Memory::Device)?,
        Buffer::new(context, "grid.list_sums", 4 * sums, Memory::Device)?,
        Buffer::new(context, "grid.unsorted", 4 * pairs, Memory::Device)?,
    ])
}

impl Lists {
    /// Creates lists of the triangles of a grid whose buffers are in the set `grid`.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub(super) fn new(context: &Context, world: &World, size: u32, grid: &Bindings) -> Result<Self> {
        let first = u64::from(world.triangle_capacity().max(SCANNED));
        let note = [&shaders::PAIRS_STEP_0, &shaders::PAIRS_STEP_1, &shaders::PAIRS_STEP_2];
        Self::noted(context, size, (grid, &[]), first, (&TRIANGLES, note), &world.constants())
    }

    /// Creates lists of all pairs found by the three shaders of `note`. These shaders use the grid's set, the lists' set, and then the sets
    /// of `more`. The initial capacity is `first` pairs.
    fn noted(
        context: &Context,
        size: u32,
        (grid, more): (&Bindings, &[&Bindings]),
        first: u64,
        (listed, note): (&'static ListKind, [&Shader; 3]),
        constants: &Constants,
    ) -> Result<Self> {
        let bricks = side(size, 0).pow(3) + 1;
        let [pairs, words, sums, unsorted] =
            room(context, bricks, first, u64::from(bricks) + 1 + 2 * LIST_WORDS * first)?;
        let bytes = size_of::<ListTotals>() as u64;
        let totals = Buffer::new(context, "grid.list_totals", bytes, Memory::Device)?;
        let set = set::GridLists { pairs: &pairs, lists: &words, sums: &sums, totals: &totals, unsorted: &unsorted };
        let set = set.bind(context, "grid.lists")?;
        let noting: Vec<_> = [grid, &set].into_iter().chain(more.iter().copied()).collect();
        let noter = |shader| Kernel::compute(context, shader, &noting, constants);
        let kernel = |shader| Kernel::compute(context, shader, &[grid, &set], &Constants::new());
        Ok(Self {
            context: context.clone(),
            bricks,
            pairs,
            words,
            sums,
            totals,
            unsorted,
            counted: ReadBack::new(context, "grid.list_counted", bytes)?,
            last: ListTotals::default(),
            listed,
            note: [noter(note[0])?, noter(note[1])?, noter(note[2])?],
            number: [kernel(&shaders::NUMBER_STEP_0)?, kernel(&shaders::NUMBER_STEP_1)?],
            fill: [kernel(&shaders::FILL_STEP_0)?, kernel(&shaders::FILL_STEP_1)?],
            starts: [kernel(&shaders::STARTS_STEP_0)?, kernel(&shaders::STARTS_STEP_1)?],
            rank: kernel(&shaders::RANK)?,
            sort: kernel(&shaders::SORT)?,
            set,
        })
    }

    /// Occupies the voxels of an empty grid, whose placement is set, and lists the triangles of each voxel.
    pub(super) fn record(&self, commands: &mut Commands, world: &World) {
        self.list(commands, world, world.triangle_count());
    }

    /// Records the passes that build the lists of `count` triangles or casters.
    fn list(&self, commands: &mut Commands, world: &World, count: u32) {
        let [clearing, noting, numbering, filling, starting, ranking, sorting] = self.listed.passes;
        let (triangle_count, caster_count) = (world.triangle_count(), world.caster_count());
        let pairs_room = (self.pairs.bytes() / PAIR_BYTES) as u32;
        let share = caster_share(&self.context, caster_count);
        let push = GridPush { triangle_count, caster_count, pairs_room, share, ..GridPush::zeroed() };
        let run = |commands: &mut Commands, name, kernel: &Kernel<GridPush>, threads: u64, each: u32| {
            let [x, y] = groups(threads.div_ceil(u64::from(each)));
            commands.pass(name, |pass| pass.dispatch(kernel, &push, [x, y, 1]));
        };
        commands.read_back(&self.totals, &self.counted);
        let bricks = 4 * u64::from(self.bricks);
        commands.pass(clearing, |pass| {
            pass.fill(&self.totals, 0);
            pass.fill_part(&self.words, bricks, self.words.bytes() - bricks, 0);
        });
        run(commands, noting, &self.note[0], count.into(), THREADS);
        commands.pass(noting, |pass| {
            pass.dispatch(&self.note[1], &push, [LARGE_GROUPS, 1, 1]);
            pass.dispatch(&self.note[2], &push, [LARGE_GROUPS, 1, 1]);
        });
        for number in &self.number {
            run(commands, numbering, number, self.bricks.into(), SCANNED);
        }
        // The number of used voxels cannot exceed the number of pairs.
        let pairs = self.pairs.bytes() / PAIR_BYTES;
        run(commands, filling, &self.fill[0], pairs, THREADS);
        for starts in &self.starts {
            run(commands, starting, starts, pairs, SCANNED);
        }
        run(commands, filling, &self.fill[1], pairs, THREADS);
        run(commands, ranking, &self.rank, pairs, THREADS);
        run(commands, sorting, &self.sort, pairs, THREADS);
    }

    /// Reads the counts of the completed frame `frame`. If the pairs or the lists did not fit, enlarges the buffers and returns true.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device has no room for them.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        let Some(counted) = self.counted.read::<ListTotals>(frame, 1)? else { return Ok(false) };
        let Some(totals) = counted.first().copied() else { return Ok(false) };
        let totals = ListTotals { voxels: totals.voxels.saturating_sub(1), ..totals };
        if totals.overflowed != 0 {
            return Err(Error::Gpu {
                operation: "list",
                name: format!("the {} of each voxel", self.listed.what),
                cause: "they are more than 4,294,967,295".into(),
                way_out: WayOut::Less(&[Less::Map, Less::Casters]),
            });
        }
        self.last = totals;
        let (pairs, words) = (u64::from(totals.pairs), totals.words(self.bricks));
        if PAIR_BYTES * pairs <= self.pairs.bytes() && 4 * words <= self.words.bytes() {
            return Ok(false);
        }
        // An eighth more than needed, so that the buffers of an animated scene do not grow every frame. The device's buffer size limit caps
        // the capacity, but never below what is needed.
        let most = u64::from(self.context.features().max_storage_buffer_range);
        let more = |count: u64, bytes: u64| (count + count / 8).min(most / bytes).max(count);
        let lists = more(words - u64::from(self.bricks), 4) + u64::from(self.bricks);
        let [pairs, words, sums, unsorted] =
            room(&self.context, self.bricks, more(pairs, PAIR_BYTES), lists.min(most / 4).max(words))?;
        self.set.replace(set::GridLists::PAIRS, &pairs)?;
        self.set.replace(set::GridLists::LISTS, &words)?;
        self.set.replace(set::GridLists::SUMS, &sums)?;
        self.set.replace(set::GridLists::UNSORTED, &unsorted)?;
        (self.pairs, self.words, self.sums, self.unsorted) = (pairs, words, sums, unsorted);
        // Frames already recorded used smaller buffers, so their counts do not show what fits now.
        self.counted.forget();
        Ok(true)
    }

    /// Reads back the words of the lists, as many as the last build used.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub(super) fn read(&self) -> Result<Vec<u32>> {
        self.words.read(self.last.words(self.bricks) as usize)
    }

    /// Returns the number of bytes that only a build needs.
    pub(super) fn transient_bytes(&self) -> u64 {
        self.pairs.bytes() + self.sums.bytes() + self.totals.bytes() + self.unsorted.bytes()
    }
}

/// Smoke and hair in a grid that lists them: separate occupancy bits, and the casters of each voxel.
pub(super) struct CastLists {
    size: u32,
    /// Occupancy bits, in the order of the grid's bits.
    pub(super) bits: Buffer,
    large: Buffer,
    pub(super) lists: Lists,
    clear: Kernel<GridPush>,
}

impl CastLists {
    /// Initial capacity, in pairs per caster.
    const FIRST: u32 = 8;

    /// Creates lists of the casters in a grid whose placement is in `data`.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub(super) fn new(context: &Context, world: &World, size: u32, data: &Buffer) -> Result<Self> {
        let capacity = world.caster_capacity();
        let bits = Buffer::zeroed(context, "grid.cast_bits", 8 * u64::from(grid_words(size)))?;
        let listed = LISTS_BYTES + 4 * u64::from(capacity.max(1));
        let large = Buffer::new(context, "grid.cast_large", listed, Memory::Device)?;
        let set = set::Grid { grid: data, grid_bits: &bits, triangles: &world.triangles, listed: &large };
        let set = set.bind(context, "grid.cast_bits")?;
        let casters = set::GridCastLists { casters: &world.casters }.bind(context, "grid.cast_lists")?;
        let first = u64::from(capacity.max(SCANNED)) * u64::from(Self::FIRST);
        let note = [&shaders::CASTERS_STEP_0, &shaders::CASTERS_STEP_1, &shaders::CASTERS_STEP_2];
        let lists = Lists::noted(context, size, (&set, &[&casters]), first, (&CASTERS, note), &Constants::new())?;
        let clear = Kernel::compute(context, &grid::CLEAR, &[&set], &Constants::new())?;
        Ok(Self { size, bits, large, lists, clear })
    }

    /// Lists the current casters in a grid whose placement is set.
    pub(super) fn record(&self, commands: &mut Commands, world: &World) {
        let [x, y] = groups(u64::from(side(self.size, 1).pow(3)));
        let top = 8 * u64::from(side(self.size, 2).pow(3));
        let [clearing, ..] = self.lists.listed.passes;
        commands.pass(clearing, |pass| pass.dispatch(&self.clear, &GridPush::zeroed(), [x, y, 1]));
        commands.pass(clearing, |pass| {
            pass.fill_part(&self.large, 0, LISTS_BYTES, 0);
            pass.fill_part(&self.bits, self.bits.bytes() - top, top, 0);
        });
        self.lists.list(commands, world, world.caster_count());
    }

    /// Returns the number of bytes that a look-up needs.
    pub(super) fn resident_bytes(&self) -> u64 {
        self.bits.bytes() + self.lists.words.bytes()
    }

    /// Returns the number of bytes that only a build needs.
    pub(super) fn transient_bytes(&self) -> u64 {
        self.large.bytes() + self.lists.transient_bytes()
    }
}
