//! Lists of a picture's casters per tile of 8 × 8 pixels, from far to near: passes find each caster's tiles, write the entries of all
//! casters in caster order, and sort them by tile. Lists are cut into parts. Twin: reference::twin::painter.

use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, Pass, Push, ReadBack, groups, push_struct,
};
use crate::maps::CountedOrder;
use crate::shaders::constant::{BY_PLACE, SORT_BLOCK};
use crate::shaders::{painter as shaders, set};
use crate::shading::Renderer;
use bytemuck::{Pod, Zeroable};
use std::cell::Cell;
use std::ops::Range;

/// Pixels per side of a tile. Twin: PAINT_TILE.
pub const TILE: u32 = 8;

/// Casters or tiles per workgroup. Twin: LIST_THREADS.
const THREADS: u32 = 128;

/// Minimum number of entries in a part, unless its tile has fewer. A part takes as long as its casters one after another: on an H200, parts
/// of 64, 32, 16 and 8 of plume_8k took 0.156, 0.133, 0.107 and 0.098 ms, and compositing them took 0.005, 0.006, 0.008 and 0.012 ms.
const LEAST_PART: u32 = 16;

/// Minimum part length that is longer than any list, so that each list is one part.
pub(super) const WHOLE: u32 = 1 << 31;

/// Maximum number of parts into which lists are cut, besides one per tile: several times as many as fill a large GPU.
const MOST_PARTS: u32 = 8192;

/// Initial capacity of the lists, in entries per caster.
const FIRST_ENTRIES: u32 = 8;

/// Maximum number of entries at a time. If there would be more, casters are painted in several runs, one after another.
const MOST_ENTRIES: u32 = 1 << 23;

/// Bytes per entry, in both halves of the sort together.
const ENTRY_BYTES: u32 = 16;

push_struct! {
    /// Twin: ListPush in glsl/shading/painter/list_set.glsl.
    struct ListPush {
        size: [u32; 2],
        first: u32,
        count: u32,
        capacity: u32,
        sorted: u32,
        least_part: u32,
        most_parts: u32,
        is_first: u32,
    }
}

/// Twin: Part in glsl/shading/painter/lists.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PartData {
    /// Index of the tile, row by row.
    pub tile: u32,
    /// Number of the part, counted from the farthest.
    pub number: u32,
    /// Number of parts of the tile.
    pub count: u32,
    /// Slot of the layer of the tile's first part.
    pub slot: u32,
}

/// Twin: PaintTotals in glsl/shading/painter/lists.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PaintTotals {
    /// Number of entries that fit.
    pub entries: u32,
    /// Arguments of a dispatch over blocks of entries.
    pub entry_groups: [u32; 3],
    /// Number of entries, whether they fit or not.
    pub wanted: u32,
    /// Maximum of `wanted` over all lists of the frame.
    pub most_wanted: u32,
    /// Index of the first sorted entry.
    pub sorted: u32,
    /// Maximum number of entries per part.
    pub part_entries: u32,
    /// Number of layers stored.
    pub slots: u32,
    /// Number of parts.
    pub parts: u32,
    /// Arguments of a dispatch over the parts.
    pub part_groups: [u32; 3],
    /// Number of tiles with several parts.
    pub split: u32,
    /// Arguments of a dispatch over those tiles.
    pub split_groups: [u32; 3],
}

/// The last frame's lists, read back to compare with the twin.
pub struct ListReadback {
    /// For each caster, the first and the last pixel that it may cover: x in the lower 16 bits, y in the upper 16. The caster covers none
    /// if the last x is below the first.
    pub boxes: Vec<[u32; 2]>,
    /// For each tile, row by row, its casters from far to near.
    pub lists: Vec<Vec<u32>>,
    /// The parts into which lists are cut, in no particular order.
    pub parts: Vec<PartData>,
    /// Counts of entries, parts and tiles.
    pub totals: PaintTotals,
}

/// The casters to list.
pub(super) struct ListSource<'a> {
    /// Indices of casters, in the order of each tile's list.
    pub order: &'a Buffer,
    /// Maximum number of casters.
    pub room: u32,
    /// Minimum length of a part.
    pub least: u32,
    /// Whether entries hold a caster's position in the order, rather than its index.
    pub by_place: bool,
}

/// Buffers and passes of the lists.
pub(in crate::shading) struct Lists {
    context: Context,
    tiles: u32,
    /// Minimum length of a part, and maximum number of parts.
    cut: [u32; 2],
    boxes: Buffer,
    sums: Buffer,
    ranges: Buffer,
    splits: Buffer,
    totals: Buffer,
    totalled: ReadBack,
    /// The last frame recorded.
    recorded: Cell<u64>,
    /// The last frame that may lack casters, if there is one.
    short_until: Option<u64>,
    grown: SizedBuffers,
    /// Number of runs in which casters are painted, one after another, because they do not fit into the lists all at once.
    runs: u32,
    set: Bindings,
    /// Set 0 of the passes that paint.
    pub(super) scene: Bindings,
    /// Set 1 of the pass that composites parts.
    pub(super) split: Bindings,
    /// Set 3 of the pass that paints a slice.
    pub(super) slices: Bindings,
    size: [u32; 2],
    constants: Constants,
    kernels: Kernels,
}

/// The passes that build the lists.
struct Kernels {
    count: Kernel<ListPush>,
    scan: Kernel<ListPush>,
    pairs: Kernel<ListPush>,
    tiles: Kernel<ListPush>,
    parts: Kernel<ListPush>,
}

impl Kernels {
    fn new(context: &Context, set: &Bindings, constants: &Constants, block: u32) -> Result<Self> {
        let constants = constants.clone().set(SORT_BLOCK, block);
        let kernel = |shader| Kernel::compute(context, shader, &[set], &constants);
        Ok(Self {
            count: kernel(&shaders::COUNT)?,
            scan: kernel(&shaders::SCAN)?,
            pairs: kernel(&shaders::PAIRS)?,
            tiles: kernel(&shaders::TILES)?,
            parts: kernel(&shaders::PARTS)?,
        })
    }
}

/// Buffers that are recreated if they were too small.
struct SizedBuffers {
    order: CountedOrder,
    parts: Buffer,
    layers: Buffer,
}

impl SizedBuffers {
    fn new(context: &Context, totals: &Buffer, capacity: u32, tiles: u32, [least, most]: [u32; 2]) -> Result<Self> {
        let cuts = u64::from(most.min(capacity.div_ceil(least)));
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        // One part per tile, plus the cuts. The last workgroups of a dispatch may find no part.
        let parts = u64::from(tiles) + cuts + 1;
        // Any two parts of a tile together hold more than the maximum number of entries per part; a layer has six floats for each of 64
        // pixels.
        let slots = 2 * cuts + 2;
        Ok(Self {
            order: CountedOrder::new(context, capacity, tiles, totals)?,
            parts: buffer("painter.parts", parts * size_of::<PartData>() as u64)?,
            layers: buffer("painter.layers", slots * 24 * u64::from(TILE * TILE))?,
        })
    }

    fn bytes(&self) -> u64 {
        self.order.bytes() + self.parts.bytes() + self.layers.bytes()
    }
}

/// Returns the default minimum length of a part. Software devices have few threads, and paint each list as one part.
pub(in crate::shading) fn usual_part(context: &Context) -> u32 {
    if context.features().is_software() { WHOLE } else { LEAST_PART }
}

impl Lists {
    /// Creates lists of all casters in the pictures of `renderer`, from far to near.
    pub(in crate::shading) fn of_all(renderer: &Renderer) -> Result<Self> {
        let (order, room) = (&renderer.blending.order, renderer.blending.room());
        Self::new(renderer, &ListSource { order, room, least: renderer.least_part, by_place: false })
    }

    /// Creates lists for the pictures of `renderer`.
    pub(super) fn new(renderer: &Renderer, listed: &ListSource) -> Result<Self> {
        let ListSource { order, room, least, by_place } = *listed;
        let (context, size) = (&renderer.context, renderer.targets.color.size());
        let [x, y] = size.map(|side| side.div_ceil(TILE));
        let (tiles, casters) = (x * y, room.max(1));
        let cut = [least, MOST_PARTS];
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        let totals = buffer("painter.totals", size_of::<PaintTotals>() as u64)?;
        let capacity = casters.saturating_mul(FIRST_ENTRIES).clamp(1024, most_entries(context));
        let grown = SizedBuffers::new(context, &totals, capacity, tiles, cut)?;
        let boxes = buffer("painter.boxes", 8 * u64::from(casters))?;
        let sums = buffer("painter.sums", 4 * u64::from(casters.div_ceil(THREADS)))?;
        let ranges = buffer("painter.ranges", 8 * u64::from(tiles))?;
        let splits = buffer("painter.splits", u64::from(tiles) * size_of::<PartData>() as u64)?;
        let set = set::PainterLists {
            casters: &renderer.scene.casters,
            order,
            boxes: &boxes,
            sums: &sums,
            items: &grown.order.items,
            ranges: &ranges,
            parts: &grown.parts,
            splits: &splits,
            totals: &totals,
            camera: &renderer.scene.camera,
        };
        let set = set.bind(context, "painter.lists")?;
        let scene = set::PainterScene {
            triangles: &renderer.scene.triangles,
            lights: &renderer.scene.lights,
            casters: &renderer.scene.casters,
            splats: &renderer.scene.splats,
            items: &grown.order.items,
            ranges: &ranges,
            parts: &grown.parts,
            totals: &totals,
            layers: &grown.layers,
            boxes: &boxes,
        };
        let scene = scene.bind(context, "painter.scene")?;
        let split = set::PainterSplits { splits: &splits }.bind(context, "painter.splits")?;
        let slices = set::PainterSlices {
            sorted: order,
            items: &grown.order.items,
            ranges: &ranges,
            parts: &grown.parts,
            totals: &totals,
        };
        let slices = slices.bind(context, "painter.slices")?;
        let constants = renderer.with_kinds(Constants::new()).set(BY_PLACE, by_place);
        Ok(Self {
            context: context.clone(),
            tiles,
            cut,
            totalled: ReadBack::new(context, "painter.totalled", totals.bytes())?,
            recorded: Cell::default(),
            short_until: None,
            kernels: Kernels::new(context, &set, &constants, grown.order.block())?,
            constants,
            size,
            boxes,
            sums,
            ranges,
            splits,
            totals,
            grown,
            runs: 1,
            set,
            scene,
            split,
            slices,
        })
    }

    /// Splits the positions `places`, in an order of `all` casters, at the boundaries of the runs into which all
    /// casters are divided.
    pub(super) fn runs(&self, places: &Range<u32>, all: u32) -> impl Iterator<Item = Range<u32>> + use<> {
        let (places, all, runs) = (places.clone(), u64::from(all), u64::from(self.runs));
        let at = move |i: u64| (i * all / runs) as u32;
        (0..runs).map(move |i| at(i).max(places.start)..at(i + 1).min(places.end)).filter(|run| !run.is_empty())
    }

    /// Returns the number of runs into which all casters are divided.
    pub(super) fn run_count(&self) -> u32 {
        self.runs
    }

    fn push(&self, run: &Range<u32>, is_first: bool) -> ListPush {
        let [least_part, most_parts] = self.cut;
        ListPush {
            size: self.size,
            first: run.start,
            count: run.end - run.start,
            capacity: self.grown.order.capacity(),
            sorted: self.grown.order.first(),
            least_part,
            most_parts,
            is_first: is_first.into(),
        }
    }

    /// Records the passes that count the entries of the casters at positions `run` of the order.
    pub(super) fn measure(&self, commands: &mut Commands, run: &Range<u32>, is_first: bool) {
        self.recorded.set(commands.frame());
        let push = self.push(run, is_first);
        self.count(commands, &push);
        self.scan(commands, &push);
        commands.read_back(&self.totals, &self.totalled);
    }

    /// Records the passes that list the casters at positions `run` of the order.
    pub(super) fn record(&self, commands: &mut Commands, run: &Range<u32>, is_first: bool) {
        let push = self.push(run, is_first);
        self.measure(commands, run, is_first);
        self.pairs(commands, &push);
        self.grown.order.sort(commands);
        self.tiles(commands, &push);
        self.parts(commands, &push);
    }

    fn count(&self, commands: &mut Commands, push: &ListPush) {
        commands.pass("painter.count", |pass| pass.dispatch(&self.kernels.count, push, caster_groups(push)));
    }

    fn scan(&self, commands: &mut Commands, push: &ListPush) {
        commands.pass("painter.scan", |pass| pass.dispatch(&self.kernels.scan, push, [1; 3]));
    }

    fn pairs(&self, commands: &mut Commands, push: &ListPush) {
        commands.pass("painter.pairs", |pass| pass.dispatch(&self.kernels.pairs, push, caster_groups(push)));
    }

    fn tiles(&self, commands: &mut Commands, push: &ListPush) {
        commands.pass("painter.tiles", |pass| {
            let offset = std::mem::offset_of!(PaintTotals, entry_groups) as u64;
            pass.dispatch_indirect(&self.kernels.tiles, push, &self.totals, offset);
        });
    }

    fn parts(&self, commands: &mut Commands, push: &ListPush) {
        let [x, y] = groups(u64::from(self.tiles.div_ceil(THREADS)));
        commands.pass("painter.parts", |pass| pass.dispatch(&self.kernels.parts, push, [x, y, 1]));
    }

    /// Runs a shader with one workgroup per part.
    pub(super) fn per_part<P: Push>(&self, pass: &mut Pass, kernel: &Kernel<P>, push: &P) {
        let offset = std::mem::offset_of!(PaintTotals, part_groups) as u64;
        pass.dispatch_indirect(kernel, push, &self.totals, offset);
    }

    /// Runs a shader with one workgroup per tile that has several parts.
    pub(super) fn per_split<P: Push>(&self, pass: &mut Pass, kernel: &Kernel<P>, push: &P) {
        let offset = std::mem::offset_of!(PaintTotals, split_groups) as u64;
        pass.dispatch_indirect(kernel, push, &self.totals, offset);
    }

    /// Returns whether lists may be cut into parts.
    pub(super) fn may_split(&self) -> bool {
        self.cut[0] != WHOLE
    }

    /// Enlarges the lists for entries that did not fit in the completed frame `frame`. Returns whether there were any; that frame then
    /// lacks casters.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        let Some(totals) = self.totalled.read::<PaintTotals>(frame, 1)? else {
            return Ok(self.short_until.is_some_and(|last| frame <= last));
        };
        let (wanted, capacity) = (totals.first().map_or(0, |t| t.most_wanted), self.grown.order.capacity());
        if wanted <= capacity {
            return Ok(false);
        }
        let most = most_entries(&self.context);
        if capacity < most {
            // An eighth more than needed, so that an animated scene does not grow the lists every frame.
            let wanted = wanted.saturating_add(wanted / 8).min(most);
            let grown = SizedBuffers::new(&self.context, &self.totals, wanted, self.tiles, self.cut)?;
            let kernels = Kernels::new(&self.context, &self.set, &self.constants, grown.order.block())?;
            self.set.replace(set::PainterLists::ITEMS, &grown.order.items)?;
            self.set.replace(set::PainterLists::PARTS, &grown.parts)?;
            self.scene.replace(set::PainterScene::ITEMS, &grown.order.items)?;
            self.scene.replace(set::PainterScene::PARTS, &grown.parts)?;
            self.scene.replace(set::PainterScene::LAYERS, &grown.layers)?;
            self.slices.replace(set::PainterSlices::ITEMS, &grown.order.items)?;
            self.slices.replace(set::PainterSlices::PARTS, &grown.parts)?;
            (self.grown, self.kernels) = (grown, kernels);
        } else {
            self.halve_runs();
        }
        self.totalled.forget();
        self.short_until = Some(self.recorded.get());
        Ok(true)
    }

    /// Makes later frames paint half as many casters at a time.
    pub(super) fn halve_runs(&mut self) {
        self.runs = self.runs.saturating_mul(2);
    }

    /// Reads back what the last frame's passes wrote, for a world of `casters` casters.
    pub(in crate::shading) fn seen(&self, casters: u32) -> Result<ListReadback> {
        let totals: Vec<PaintTotals> = self.totals.read(1)?;
        let totals = totals[0];
        let items: Vec<[u32; 2]> = self.grown.order.items.read_from(totals.sorted as usize, totals.entries as usize)?;
        let ranges: Vec<[u32; 2]> = self.ranges.read(self.tiles as usize)?;
        let list =
            |[start, end]: [u32; 2]| items[start as usize..end as usize].iter().map(|[_, caster]| *caster).collect();
        Ok(ListReadback {
            boxes: self.boxes.read(casters as usize)?,
            lists: ranges.into_iter().map(list).collect(),
            parts: self.grown.parts.read(totals.parts as usize)?,
            totals,
        })
    }

    /// Returns the size of all buffers, in bytes.
    pub(in crate::shading) fn bytes(&self) -> u64 {
        let buffers = [&self.boxes, &self.sums, &self.ranges, &self.splits, &self.totals];
        buffers.map(Buffer::bytes).iter().sum::<u64>() + self.grown.bytes()
    }
}

fn caster_groups(push: &ListPush) -> [u32; 3] {
    let [x, y] = groups(u64::from(push.count.div_ceil(THREADS)));
    [x, y, 1]
}

fn most_entries(context: &Context) -> u32 {
    MOST_ENTRIES.min(context.features().max_storage_buffer_range / ENTRY_BYTES)
}
