//! The triangles of each voxel: which of them it has to be asked about.

use super::{GridPush, LARGE_GROUPS, THREADS, side};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, ReadBack, groups};
use crate::shaders::lists as shaders;
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Less, Result, WayOut};
use bytemuck::{Pod, Zeroable};

/// Values that a workgroup adds up. Twin: SCANNED in glsl/grid/lists/scan.glsl.
const SCANNED: u32 = 1024;

/// What there was of all. Twin: ListTotals in glsl/grid/lists/set.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ListTotals {
    /// Of a triangle and a voxel that it meets.
    pub pairs: u32,
    /// That any triangle meets.
    pub voxels: u32,
    /// 1: more pairs than 32 bits count.
    pub overflowed: u32,
}

impl ListTotals {
    /// Words of the lists, those of `bricks` bricks among them.
    fn words(self, bricks: u32) -> u64 {
        u64::from(bricks) + 1 + u64::from(self.voxels) + u64::from(self.pairs)
    }
}

/// The lists and the passes that make them. Pairs and lists grow to what there is of them.
pub(super) struct Lists {
    context: Context,
    bricks: u32,
    pairs: Buffer,
    /// As glsl/grid/lists/place.glsl has them.
    pub(super) words: Buffer,
    sums: Buffer,
    totals: Buffer,
    /// Lists in the order in which triangles came.
    unsorted: Buffer,
    counted: ReadBack,
    /// After the last build.
    pub(super) last: ListTotals,
    set: Bindings,
    note: [Kernel<GridPush>; 3],
    number: [Kernel<GridPush>; 2],
    fill: [Kernel<GridPush>; 2],
    starts: [Kernel<GridPush>; 2],
    rank: Kernel<GridPush>,
    sort: Kernel<GridPush>,
}

/// Room for so many pairs, words, what their sums need, and triangles that are not sorted.
fn room(context: &Context, bricks: u32, pairs: u64, words: u64) -> Result<[Buffer; 4]> {
    let sums = u64::from(bricks).max(pairs).div_ceil(u64::from(SCANNED));
    Ok([
        Buffer::new(context, "grid.pairs", 8 * pairs, Memory::Device)?,
        Buffer::new(context, "grid.lists", 4 * words, Memory::Device)?,
        Buffer::new(context, "grid.list_sums", 4 * sums, Memory::Device)?,
        Buffer::new(context, "grid.unsorted", 4 * pairs, Memory::Device)?,
    ])
}

impl Lists {
    /// Of a grid whose own buffers are `grid`.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub(super) fn new(context: &Context, world: &World, size: u32, grid: &Bindings) -> Result<Self> {
        let bricks = side(size, 0).pow(3);
        let first = u64::from(world.triangle_capacity().max(SCANNED));
        let [pairs, words, sums, unsorted] = room(context, bricks, first, u64::from(bricks) + 1 + 2 * first)?;
        let bytes = size_of::<ListTotals>() as u64;
        let totals = Buffer::new(context, "grid.list_totals", bytes, Memory::Device)?;
        let set = set::GridLists { pairs: &pairs, lists: &words, sums: &sums, totals: &totals, unsorted: &unsorted };
        let set = set.bind(context, "grid.lists")?;
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
            note: [kernel(&shaders::PAIRS_STEP_0)?, kernel(&shaders::PAIRS_STEP_1)?, kernel(&shaders::PAIRS_STEP_2)?],
            number: [kernel(&shaders::NUMBER_STEP_0)?, kernel(&shaders::NUMBER_STEP_1)?],
            fill: [kernel(&shaders::FILL_STEP_0)?, kernel(&shaders::FILL_STEP_1)?],
            starts: [kernel(&shaders::STARTS_STEP_0)?, kernel(&shaders::STARTS_STEP_1)?],
            rank: kernel(&shaders::RANK)?,
            sort: kernel(&shaders::SORT)?,
            set,
        })
    }

    /// Occupies the voxels of an empty grid that stands where it should, and lists the triangles of each.
    pub(super) fn record(&self, commands: &mut Commands, world: &World) {
        let triangle_count = world.triangle_count();
        let pairs_room = (self.pairs.bytes() / 8) as u32;
        let push = GridPush { triangle_count, pairs_room, ..GridPush::zeroed() };
        let run = |commands: &mut Commands, name, kernel: &Kernel<GridPush>, threads: u64, each: u32| {
            let [x, y] = groups(threads.div_ceil(u64::from(each)));
            commands.pass(name, |pass| pass.dispatch(kernel, &push, [x, y, 1]));
        };
        commands.read_back(&self.totals, &self.counted);
        let bricks = 4 * u64::from(self.bricks);
        commands.pass("grid.clear_lists", |pass| {
            pass.fill(&self.totals, 0);
            pass.fill_part(&self.words, bricks, self.words.bytes() - bricks, 0);
        });
        run(commands, "grid.pairs", &self.note[0], triangle_count.into(), THREADS);
        commands.pass("grid.pairs", |pass| {
            pass.dispatch(&self.note[1], &push, [LARGE_GROUPS, 1, 1]);
            pass.dispatch(&self.note[2], &push, [LARGE_GROUPS, 1, 1]);
        });
        for number in &self.number {
            run(commands, "grid.number", number, self.bricks.into(), SCANNED);
        }
        // As many voxels are used at most as there are pairs.
        let pairs = self.pairs.bytes() / 8;
        run(commands, "grid.fill", &self.fill[0], pairs, THREADS);
        for starts in &self.starts {
            run(commands, "grid.starts", starts, pairs, SCANNED);
        }
        run(commands, "grid.fill", &self.fill[1], pairs, THREADS);
        run(commands, "grid.rank", &self.rank, pairs, THREADS);
        run(commands, "grid.sort", &self.sort, pairs, THREADS);
    }

    /// Looks at what there was in frame `frame`, which is over. Where it did not fit, makes room, and says so.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device has no room for it.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        let Some(counted) = self.counted.read::<ListTotals>(frame, 1)? else { return Ok(false) };
        let Some(totals) = counted.first().copied() else { return Ok(false) };
        if totals.overflowed != 0 {
            return Err(Error::Gpu {
                operation: "list",
                name: "the triangles of each voxel".into(),
                cause: "they are more than 4,294,967,295".into(),
                way_out: WayOut::Less(&[Less::Map, Less::Casters]),
            });
        }
        self.last = totals;
        let (pairs, words) = (u64::from(totals.pairs), totals.words(self.bricks));
        if 8 * pairs <= self.pairs.bytes() && 4 * words <= self.words.bytes() {
            return Ok(false);
        }
        // An eighth more, so that a scene in motion does not grow every frame; only what is needed if that is too much.
        let most = u64::from(self.context.features().max_storage_buffer_range);
        let more = |count: u64, bytes: u64| (count + count / 8).min(most / bytes).max(count);
        let lists = more(words - u64::from(self.bricks), 4) + u64::from(self.bricks);
        let [pairs, words, sums, unsorted] =
            room(&self.context, self.bricks, more(pairs, 8), lists.min(most / 4).max(words))?;
        self.set.replace(set::GridLists::PAIRS, &pairs)?;
        self.set.replace(set::GridLists::LISTS, &words)?;
        self.set.replace(set::GridLists::SUMS, &sums)?;
        self.set.replace(set::GridLists::UNSORTED, &unsorted)?;
        (self.pairs, self.words, self.sums, self.unsorted) = (pairs, words, sums, unsorted);
        // Frames that are recorded already were given less room.
        self.counted.forget();
        Ok(true)
    }

    /// All words that say something, after a build.
    ///
    /// # Errors
    /// [`Error::Gpu`] where they cannot be read back.
    pub(super) fn read(&self) -> Result<Vec<u32>> {
        self.words.read(self.last.words(self.bricks) as usize)
    }

    /// Of all that only a build needs.
    pub(super) fn transient_bytes(&self) -> u64 {
        self.pairs.bytes() + self.sums.bytes() + self.totals.bytes() + self.unsorted.bytes()
    }
}
