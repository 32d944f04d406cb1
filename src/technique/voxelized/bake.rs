//! The passes of a bake, tile by tile, level by level.

use super::Plan;
use super::buffers::{
    Buffers, BuildPush, BuildState, Groups, LARGE_OFFSET, LevelCounts, PIECES_OFFSET, Room, SCANNED, Shape,
    WORDS_OFFSET,
};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Kernel, Pass, groups};
use crate::shaders::constant::{CLOSED, FREE, KEEP_COLUMNS, MERGE, PERSPECTIVE};
use crate::shaders::voxelized as shaders;

/// Threads per workgroup of most passes.
const THREADS: u32 = 64;

/// Number of workgroups that share the large triangles.
const LARGE_GROUPS: u32 = 256;

/// The kernels of a bake, all with the same descriptor set.
pub struct Bake {
    /// One for parallel light, one for lights with a position.
    project: [Kernel<BuildPush>; 2],
    bin: [Kernel<BuildPush>; 4],
    columns: [Kernel<BuildPush>; 2],
    ranges: Kernel<BuildPush>,
    scan: Kernel<BuildPush>,
    sums: [Kernel<BuildPush>; 3],
    plan: Kernel<BuildPush>,
    leaves: Kernel<BuildPush>,
    nodes: Kernel<BuildPush>,
    merge: Kernel<BuildPush>,
    rank: Kernel<BuildPush>,
    keep: Kernel<BuildPush>,
    top: Kernel<BuildPush>,
    size: Kernel<BuildPush>,
    pack: Kernel<BuildPush>,
    root: Kernel<BuildPush>,
    shortcuts: Kernel<BuildPush>,
    merges: bool,
}

/// The tree being baked, and the buffers for it.
pub struct Job<'a> {
    pub buffers: &'a Buffers,
    pub room: &'a Room,
    pub shape: Shape,
    /// Index of the tree.
    pub light: u32,
    /// Whether the tree's light has a position.
    pub perspective: bool,
    /// [`Mode`](super::buffers::Mode).
    pub mode: u32,
}

impl Bake {
    /// `constants` are the world's.
    pub fn new(context: &Context, set: &Bindings, plan: &Plan, constants: Constants) -> Result<Self> {
        let constants = plan
            .constants(constants)
            .set(MERGE, plan.merges())
            .set(FREE, plan.free as u32)
            .set(CLOSED, plan.closed)
            .set(KEEP_COLUMNS, plan.keep_columns);
        let kernel = |shader| Kernel::compute(context, shader, &[set], &constants);
        let both = |shader| {
            let placed = constants.clone().set(PERSPECTIVE, true);
            Ok::<_, crate::Error>([kernel(shader)?, Kernel::compute(context, shader, &[set], &placed)?])
        };
        Ok(Self {
            project: both(&shaders::PROJECT)?,
            bin: [
                kernel(&shaders::BIN_STEP_0)?,
                kernel(&shaders::BIN_STEP_1)?,
                kernel(&shaders::BIN_STEP_2)?,
                kernel(&shaders::BIN_STEP_3)?,
            ],
            columns: both(&shaders::COLUMNS)?,
            ranges: kernel(&shaders::RANGES)?,
            scan: kernel(&shaders::SCAN)?,
            sums: [kernel(&shaders::SUMS_STEP_0)?, kernel(&shaders::SUMS_STEP_1)?, kernel(&shaders::SUMS_STEP_2)?],
            plan: kernel(&shaders::PLAN)?,
            leaves: kernel(&shaders::LEAVES)?,
            nodes: kernel(&shaders::NODES)?,
            merge: kernel(&shaders::MERGE)?,
            rank: kernel(&shaders::RANK)?,
            keep: kernel(&shaders::KEEP)?,
            top: kernel(&shaders::TOP)?,
            size: kernel(&shaders::SIZE)?,
            pack: kernel(&shaders::PACK)?,
            root: kernel(&shaders::ROOT)?,
            shortcuts: kernel(&shaders::SHORTCUTS)?,
            merges: plan.merges(),
        })
    }

    /// Records the passes before the first tile of a tree.
    pub fn begin(&self, commands: &mut Commands, job: &Job, triangles: u32) {
        commands.pass("voxelized.begin", |pass| {
            if job.light == 0 {
                pass.update(&job.buffers.state, &[Buffers::begin(job.room)]);
            } else {
                pass.update(&job.buffers.state, &BuildState::default().levels);
                pass.fill_part(&job.buffers.state, PIECES_OFFSET, 8, 0);
            }
            if self.merges {
                pass.fill(&job.buffers.table, 0);
            }
        });
        let push = BuildPush { triangle_count: triangles, width: job.shape.bricks(), ..job.columns(0) };
        let [x, y] = groups(u64::from(triangles.div_ceil(THREADS)));
        commands.pass("voxelized.project", |pass| pass.dispatch(job.of(&self.project), &push, [x, y, 1]));
    }

    /// Records all passes of one tile, up to the nodes that are as wide as the tile. Source: ours; levels after Kämpe et al. 2016,
    /// section 4.
    pub fn tile(&self, commands: &mut Commands, job: &Job, [tile_x, tile_y]: [u32; 2], triangles: u32) {
        let shape = job.shape;
        let [bins_at, placed_at] = shape.bins_at();
        let bins = shape.bins().pow(2);
        let base = BuildPush {
            width: shape.bricks(),
            tile_x: tile_x * shape.tile,
            tile_y: tile_y * shape.tile,
            ..job.columns(tile_y * shape.tiles() + tile_x)
        };
        let bin = BuildPush { bins_at, placed_at, triangle_count: triangles, ..base };
        let [x, y] = groups((u64::from(triangles) + u64::from(job.room.pieces)).div_ceil(THREADS.into()));
        commands.pass("voxelized.bin", |pass| {
            pass.fill_part(&job.buffers.values, 0, 4 * u64::from(shape.blocks_at()), 0);
            pass.fill_part(&job.buffers.state, LARGE_OFFSET, 4, 0);
        });
        commands.pass("voxelized.bin", |pass| pass.dispatch(&self.bin[0], &bin, [x, y, 1]));
        commands.pass("voxelized.bin", |pass| pass.dispatch(&self.bin[1], &bin, [LARGE_GROUPS, 1, 1]));
        self.scan(commands, BuildPush { scan_at: bins_at, scan_count: bins, level: 0, ..base });
        commands.pass("voxelized.bin", |pass| {
            pass.dispatch(&self.bin[2], &bin, [x, y, 1]);
            pass.dispatch(&self.bin[3], &bin, [LARGE_GROUPS, 1, 1]);
        });
        let columns = BuildPush { bins_at, leaves_at: shape.level_at(0), bricks_at: shape.level_at(1), ..base };
        let [x, y] = groups(u64::from(shape.bricks().pow(2)));
        commands.pass("voxelized.columns", |pass| pass.dispatch(job.of(&self.columns), &columns, [x, y, 1]));

        self.ranges(commands, base, 1, shape.tile_level(), |level| shape.level_at(level));
        self.scan(
            commands,
            BuildPush { scan_at: shape.blocks_at(), scan_count: shape.tile_counts(), level: 1, ..base },
        );
        let plan = BuildPush {
            at: shape.blocks_at(),
            level: 0,
            level_count: shape.tile_level() + 1,
            node_capacity: job.room.node_candidates,
            leaf_capacity: job.room.leaf_candidates,
            ..base
        };
        commands.pass("voxelized.plan", |pass| pass.dispatch(&self.plan, &plan, [1, 1, 1]));
        for level in 0..=shape.tile_level() {
            let width = if level == 0 { shape.bricks() } else { shape.bricks() >> (level - 1) };
            let at = shape.level_at(level);
            let child_at = if level == 0 { shape.level_at(1) } else { shape.level_at(level - 1) };
            let push = job.level(BuildPush { level, width, at, child_at, ..base });
            self.level(commands, job, &push);
        }
        if shape.tiles() > 1 {
            let push = BuildPush {
                at: shape.level_at(shape.tile_level()),
                child_at: shape.top_at(),
                child_slots_at: job.room.top_slots_at(),
                child_stride: shape.tiles(),
                tile: tile_y * shape.tiles() + tile_x,
                ..job.level(BuildPush { level: shape.tile_level(), width: 1, ..base })
            };
            commands.pass("voxelized.top", |pass| pass.dispatch(&self.top, &push, [1, 1, 1]));
        }
    }

    /// Records the passes of the levels above the tiles, to run after all tiles.
    pub fn above(&self, commands: &mut Commands, job: &Job) {
        let shape = job.shape;
        if shape.tiles() == 1 {
            return;
        }
        let base = BuildPush { light: job.light, ..BuildPush::default() };
        let first = shape.tile_level() + 1;
        let wide = BuildPush { width: shape.tiles(), ..base };
        self.ranges(commands, wide, shape.tile_level(), shape.root_level(), |level| shape.top_level_at(level));
        self.scan(commands, BuildPush { scan_at: shape.top_at(), scan_count: shape.top_counts(), level: 1, ..base });
        let plan = BuildPush {
            at: shape.top_level_at(first),
            level: first,
            width: shape.tiles() / 2,
            level_count: shape.root_level() - shape.tile_level(),
            node_capacity: job.room.node_candidates,
            ..base
        };
        commands.pass("voxelized.plan", |pass| pass.dispatch(&self.plan, &plan, [1, 1, 1]));
        for level in first..=shape.root_level() {
            let width = shape.tiles() >> (level - shape.tile_level());
            let (at, child_at) = (shape.top_level_at(level), shape.top_level_at(level - 1));
            let mut push = job.level(BuildPush { level, width, at, child_at, ..base });
            if level == first {
                (push.child_stride, push.child_slots_at) = (shape.tiles(), job.room.top_slots_at());
            }
            self.level(commands, job, &push);
        }
    }

    /// Records the passes that write the data for look-ups.
    pub fn pack(&self, commands: &mut Commands, job: &Job) {
        let shape = job.shape;
        let state = &job.buffers.state;
        if job.light == 0 {
            commands.pass("voxelized.pack", |pass| {
                pass.fill(&job.buffers.data, 0);
                pass.fill_part(state, WORDS_OFFSET, 4, 0);
            });
        }
        for level in 0..=shape.root_level() {
            let push = job.level(BuildPush { level, light: job.light, ..BuildPush::default() });
            if level > 0 {
                let offset = Groups::UniqueScans.offset(level);
                commands.pass("voxelized.size", |pass| pass.dispatch_indirect(&self.size, &push, state, offset));
            }
            commands.pass("voxelized.sums", |pass| pass.dispatch(&self.sums[2], &push, [1, 1, 1]));
            let offset = Groups::Unique.offset(level);
            commands.pass("voxelized.pack", |pass| pass.dispatch_indirect(&self.pack, &push, state, offset));
        }
        let level = shape.root_level();
        let at = if shape.tiles() > 1 { shape.top_level_at(level) } else { shape.level_at(level) };
        let push = job.level(BuildPush { level, at, light: job.light, ..BuildPush::default() });
        commands.pass("voxelized.root", |pass| pass.dispatch(&self.root, &push, [1, 1, 1]));
        let [x, y] = groups(u64::from(shape.shortcuts().div_ceil(THREADS)));
        commands.pass("voxelized.shortcuts", |pass| pass.dispatch(&self.shortcuts, &push, [x, y, 1]));
    }

    /// Records the passes that find the range of each block of columns on the levels above `from`, three levels at a time. A block's range
    /// is the smallest exit and the largest entry of its columns.
    fn ranges(&self, commands: &mut Commands, base: BuildPush, from: u32, to: u32, at: impl Fn(u32) -> u32) {
        for level in (from..to).step_by(3) {
            let width = base.width >> (level - from);
            let push = BuildPush { level, width, at: at(level), ..base };
            let [x, y] = groups(u64::from(width.div_ceil(8).pow(2)));
            commands.pass("voxelized.ranges", |pass| pass.dispatch(&self.ranges, &push, [x, y, 1]));
        }
    }

    fn scan(&self, commands: &mut Commands, push: BuildPush) {
        let [x, y] = groups(u64::from(push.scan_count.div_ceil(SCANNED)));
        commands.pass("voxelized.scan", |pass| pass.dispatch(&self.scan, &push, [x, y, 1]));
        commands.pass("voxelized.sums", |pass| pass.dispatch(&self.sums[0], &push, [1, 1, 1]));
    }

    /// Records the passes that build the nodes of a level of a tile and merge them with all earlier nodes of that level.
    fn level(&self, commands: &mut Commands, job: &Job, push: &BuildPush) {
        let state = &job.buffers.state;
        let indirect = |pass: &mut Pass, kernel: &Kernel<BuildPush>, groups: Groups| {
            pass.dispatch_indirect(kernel, push, state, groups.offset(push.level));
        };
        let (name, kernel) =
            if push.level == 0 { ("voxelized.leaves", &self.leaves) } else { ("voxelized.nodes", &self.nodes) };
        commands.pass(name, |pass| indirect(pass, kernel, Groups::Candidates));
        if self.merges {
            commands.pass("voxelized.merge", |pass| indirect(pass, &self.merge, Groups::Candidates));
        }
        commands.pass("voxelized.rank", |pass| indirect(pass, &self.rank, Groups::Scans));
        commands.pass("voxelized.sums", |pass| pass.dispatch(&self.sums[1], push, [1, 1, 1]));
        commands.pass("voxelized.keep", |pass| indirect(pass, &self.keep, Groups::Candidates));
    }
}

impl Job<'_> {
    /// Returns push constants with the positions of a tile's columns.
    fn columns(&self, tile: u32) -> BuildPush {
        let before = if self.room.stays { self.light * self.shape.tiles().pow(2) + tile } else { 0 };
        let columns_at = before * self.shape.tile_words();
        BuildPush { light: self.light, columns_at, mode: self.mode, ..BuildPush::default() }
    }

    /// Returns the kernel for the projection of the tree's light: parallel or perspective.
    fn of<'k>(&self, kernels: &'k [Kernel<BuildPush>; 2]) -> &'k Kernel<BuildPush> {
        &kernels[usize::from(self.perspective)]
    }

    /// Returns `push`, with the fields that follow from its level filled in.
    fn level(&self, push: BuildPush) -> BuildPush {
        let (room, level) = (self.room, push.level);
        let below = level.saturating_sub(1);
        BuildPush {
            slots_at: room.slots_at(level),
            child_slots_at: room.slots_at(below),
            rank_at: room.rank_at(self.shape, level),
            child_rank_at: room.rank_at(self.shape, below),
            unique_at: room.unique_at(level) as u32,
            unique_capacity: room.unique_of(level),
            table_at: room.table_at(level),
            table_mask: room.table_slots(level) - 1,
            child_table_at: room.table_at(below),
            data_capacity: room.data,
            ..push
        }
    }
}

/// Returns the number of nodes on the levels `of` in the last tile, before merging.
pub fn tree_nodes(levels: &[LevelCounts], of: std::ops::RangeInclusive<u32>) -> u64 {
    of.map(|level| u64::from(levels[level as usize].candidates)).sum()
}
