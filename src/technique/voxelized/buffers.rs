//! The buffers of a bake: their sizes, their layout, and the push constants of the passes.

use super::MAX_LEVELS;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Memory, ReadBack, Resource, push_struct};
use crate::shaders::set;
use bytemuck::{Pod, Zeroable};

push_struct! {
    /// Twin: BuildPush in glsl/technique/voxelized/build.glsl, which explains each field.
    #[derive(Default)]
    pub struct BuildPush {
        light: u32,
        triangle_count: u32,
        tile: u32,
        tile_x: u32,
        tile_y: u32,
        width: u32,
        bins_at: u32,
        placed_at: u32,
        leaves_at: u32,
        bricks_at: u32,
        scan_at: u32,
        scan_count: u32,
        level: u32,
        level_count: u32,
        leaf_capacity: u32,
        node_capacity: u32,
        at: u32,
        child_at: u32,
        child_stride: u32,
        slots_at: u32,
        child_slots_at: u32,
        rank_at: u32,
        child_rank_at: u32,
        unique_at: u32,
        unique_capacity: u32,
        table_at: u32,
        table_mask: u32,
        child_table_at: u32,
        data_capacity: u32,
        columns_at: u32,
        mode: u32,
    }
}

/// Bits that select which parts of a bake are redone. Twins: WHOLE, SEEN and LAST in glsl/technique/voxelized/build.glsl.
pub struct Mode;

impl Mode {
    /// All columns are recomputed; otherwise, only columns in blocks where something moved.
    pub const WHOLE: u32 = 1;
    /// The positions of triangles are stored, so that a later bake knows which triangles moved.
    pub const SEEN: u32 = 2;
    /// The tree is the last one of the bake.
    pub const LAST: u32 = 4;
}

/// Twin: LevelCounts in glsl/technique/voxelized/build.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LevelCounts {
    /// Number of nodes in the last tile, before equal ones are merged; 0 if they did not fit.
    pub candidates: u32,
    /// Largest number of nodes in any tile, before equal ones are merged.
    pub demanded: u32,
    /// Number of nodes stored before the last tile.
    pub base: u32,
    /// Number of nodes stored.
    pub unique: u32,
    /// Size of the stored nodes in units: 16 bits in a graph, one word in a tree.
    pub units: u32,
    /// Offset of the stored nodes, in words.
    pub at: u32,
    /// Bits per pointer in these nodes.
    pub pointer_bits: u32,
    /// Number of nodes that did not fit into the table.
    pub lost: u32,
    /// Number of workgroups over the candidates, 64 candidates each.
    pub groups: [u32; 3],
    /// Number of workgroups that scan the candidates, 1,024 candidates each.
    pub blocks: [u32; 3],
    /// Number of workgroups over the stored nodes, 64 nodes each.
    pub unique_groups: [u32; 3],
    /// Number of workgroups that scan the stored nodes, 1,024 nodes each.
    pub unique_blocks: [u32; 3],
}

/// Twin: BuildState in glsl/technique/voxelized/build.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BuildState {
    /// Counts per level: leaves, bricks, and so on.
    pub levels: [LevelCounts; MAX_LEVELS],
    /// Number of triangle entries in the bins of the tile that has the most.
    pub entries: u32,
    /// Number of triangles that touch many bins of the last tile.
    pub large: u32,
    /// Number of words in all trees so far.
    pub words: u32,
    entry_capacity: u32,
    large_capacity: u32,
    /// Number of extra pieces into which the light's pyramid cuts triangles, besides the first piece of each.
    pub pieces: u32,
    moves_wide: u32,
    /// Number of blocks of 8 × 8 columns that this bake recomputed.
    pub found: u32,
    piece_capacity: u32,
    failed: u32,
}

/// Dispatches of a level, whose arguments are stored in the state.
#[derive(Clone, Copy)]
pub enum Groups {
    Candidates,
    Scans,
    Unique,
    UniqueScans,
}

impl Groups {
    pub fn offset(self, level: u32) -> u64 {
        let within = match self {
            Self::Candidates => std::mem::offset_of!(LevelCounts, groups),
            Self::Scans => std::mem::offset_of!(LevelCounts, blocks),
            Self::Unique => std::mem::offset_of!(LevelCounts, unique_groups),
            Self::UniqueScans => std::mem::offset_of!(LevelCounts, unique_blocks),
        };
        (level as usize * size_of::<LevelCounts>() + within) as u64
    }
}

/// Offset of `large` in the state, in bytes.
pub const LARGE_OFFSET: u64 = std::mem::offset_of!(BuildState, large) as u64;

/// Offset of `pieces` in the state, in bytes.
pub const PIECES_OFFSET: u64 = std::mem::offset_of!(BuildState, pieces) as u64;

/// Words per projected triangle. Twin: PROJECTED_WORDS in glsl/technique/voxelized/projected.glsl.
const PROJECTED_WORDS: u64 = 12;

/// `SEEN_WORDS`: words per triangle for its stored position, which tells the next bake whether it has moved. `BOX_WORDS`: words per box
/// around a triangle in a tree. Twins: SEEN_WORDS, BOX_WORDS in glsl/technique/voxelized/project.comp.
const SEEN_WORDS: u64 = 10;
const BOX_WORDS: u64 = 4;

/// Twin: TILE_WORDS in glsl/technique/voxelized/moves.glsl.
const TILE_WORDS: u32 = 67;

/// Maximum size in bytes of the columns that are kept for the next bake while something moves. If the columns of all trees need more, none
/// are kept.
const MOST_KEPT_BYTES: u64 = 256 << 20;

/// Offset of `words` in the state, in bytes.
pub const WORDS_OFFSET: u64 = std::mem::offset_of!(BuildState, words) as u64;

/// Columns per side of a bin of triangles. Twin: BIN_COLUMNS in glsl/technique/voxelized/projected.glsl.
const BIN_COLUMNS: u32 = 8;

/// Number of values that one workgroup scans. Twin: SCANNED in glsl/technique/voxelized/build.glsl.
pub const SCANNED: u32 = 1024;

const LEAF_WORDS: u32 = 2;
const NODE_WORDS: u32 = 9;

/// Maximum number of levels that look-ups skip. Twin: SHORTCUT_BITS in glsl/technique/voxelized/tree.glsl.
const SHORTCUT_BITS: u32 = 4;

/// The shape of a bake: sizes that follow from the number of voxels alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Voxels per side.
    pub size: u32,
    /// Columns per side of a tile.
    pub tile: u32,
}

impl Shape {
    /// Returns the number of tiles across.
    pub fn tiles(self) -> u32 {
        self.size / self.tile
    }

    /// Returns the number of bricks, nodes of 8 voxels per side, across a tile.
    pub fn bricks(self) -> u32 {
        self.tile / 8
    }

    /// Returns the level of the nodes that are as wide as a tile.
    pub fn tile_level(self) -> u32 {
        self.tile.ilog2() - 2
    }

    /// Returns the root's level.
    pub fn root_level(self) -> u32 {
        self.size.ilog2() - 2
    }

    /// Returns the number of cells in the grid at which look-ups start. The grid is as fine as one of the tree's levels above the leaves.
    pub fn shortcuts(self) -> u32 {
        1 << (3 * SHORTCUT_BITS.min(self.root_level() - 1))
    }

    /// Returns the level of the nodes that the cells of [`Shape::shortcuts`] represent.
    pub fn shortcut_level(self) -> u32 {
        self.root_level() - SHORTCUT_BITS.min(self.root_level() - 1)
    }

    /// Returns the number of bins across a tile.
    pub fn bins(self) -> u32 {
        self.tile.div_ceil(BIN_COLUMNS)
    }

    /// Returns the offsets, within the values, of two lists of counts per bin: all entries, and the entries placed so far.
    pub fn bins_at(self) -> [u32; 2] {
        [0, aligned(self.bins().pow(2))]
    }

    /// Returns the offset of the counts of a tile's leaves; the counts of bricks and so on follow.
    pub fn blocks_at(self) -> u32 {
        2 * aligned(self.bins().pow(2))
    }

    /// Returns the number of words for a tile's columns and the data kept with them.
    pub fn tile_words(self) -> u32 {
        TILE_WORDS * self.bricks().pow(2)
    }

    /// Returns whether the columns of `trees` trees may be kept.
    pub fn may_stay(self, trees: usize) -> bool {
        4 * u64::from(self.tile_words()) * u64::from(self.tiles().pow(2)) * trees as u64 <= MOST_KEPT_BYTES
    }

    /// Returns the offset of the counts of a level of a tile.
    pub fn level_at(self, level: u32) -> u32 {
        let above = (1..level).map(|l| (self.bricks() >> (l - 1)).pow(2)).sum::<u32>();
        self.blocks_at() + if level == 0 { 0 } else { self.bricks().pow(2) + above }
    }

    /// Returns the number of counts on all levels of a tile.
    pub fn tile_counts(self) -> u32 {
        self.level_at(self.tile_level() + 1) - self.blocks_at()
    }

    /// Returns the offset of the counts above the tiles: first the tiles themselves, then the levels above.
    pub fn top_at(self) -> u32 {
        self.blocks_at() + aligned(self.tile_counts())
    }

    /// Same as [`Shape::level_at`], but above the tiles.
    pub fn top_level_at(self, level: u32) -> u32 {
        let below = (self.tile_level()..level).map(|l| (self.tiles() >> (l - self.tile_level())).pow(2)).sum::<u32>();
        self.top_at() + below
    }

    pub fn top_counts(self) -> u32 {
        self.top_level_at(self.root_level() + 1) - self.top_at()
    }

    /// Returns the offset of the ranks.
    fn ranks_at(self) -> u32 {
        self.top_at() + aligned(self.top_counts())
    }
}

/// Returns `count` + 1, rounded up to whole blocks of scans: the extra element holds the sum of all values.
fn aligned(count: u32) -> u32 {
    (count + 1).next_multiple_of(SCANNED)
}

/// Capacities of a bake's buffers, in elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    pub entries: u32,
    pub large: u32,
    /// Pieces of triangles cut by a pyramid.
    pub pieces: u32,
    pub leaf_candidates: u32,
    pub node_candidates: u32,
    /// Unique nodes per level.
    pub unique: [u32; MAX_LEVELS],
    /// Words of all trees.
    pub data: u32,
    /// Whether the columns of all tiles and the positions of triangles are kept for the next bake.
    pub stays: bool,
}

impl Room {
    /// Returns initial capacities that suffice for most scenes; a bake that needs more enlarges them.
    pub fn new(shape: Shape, triangles: u32, perspective: bool) -> Self {
        let bricks = shape.bricks().pow(2);
        let unique =
            |level: usize| if level <= shape.root_level() as usize { (bricks >> (level / 2 + 2)).max(1024) } else { 0 };
        Self {
            entries: triangles.saturating_mul(4).clamp(1 << 14, super::MOST_NODES),
            large: 1024,
            pieces: if perspective { 1024 } else { 0 },
            leaf_candidates: (4 * bricks).max(4096),
            node_candidates: (bricks + bricks / 2).max(1024),
            unique: std::array::from_fn(unique),
            data: 1024,
            stays: false,
        }
    }

    /// Returns the largest of these capacities, not counting `data`.
    pub fn most(&self) -> u32 {
        let all = [self.entries, self.large, self.pieces, self.leaf_candidates, self.node_candidates];
        all.into_iter().chain(self.unique).fold(0, u32::max)
    }

    fn candidates(&self) -> u32 {
        self.leaf_candidates.max(self.node_candidates)
    }

    fn ranks(&self) -> u32 {
        aligned(self.unique.iter().copied().fold(self.candidates(), u32::max))
    }

    /// Returns the offset of the ranks of a level. There are two regions, since a pass reads a level and the one below it.
    pub fn rank_at(&self, shape: Shape, level: u32) -> u32 {
        shape.ranks_at() + (level & 1) * self.ranks()
    }

    /// Returns the offset of the hash table slots of a level's nodes, in two regions as for ranks.
    pub fn slots_at(&self, level: u32) -> u32 {
        (level & 1) * self.candidates()
    }

    /// Returns the offset of the slots of the tiles' own nodes.
    pub fn top_slots_at(&self) -> u32 {
        2 * self.candidates()
    }

    pub fn unique_of(&self, level: u32) -> u32 {
        self.unique[level as usize]
    }

    fn words_of(&self, level: u32) -> u64 {
        u64::from(self.unique_of(level)) * u64::from(if level == 0 { LEAF_WORDS } else { NODE_WORDS })
    }

    /// Returns the offset of a level's stored nodes, in words.
    pub fn unique_at(&self, level: u32) -> u64 {
        (0..level).map(|l| self.words_of(l)).sum()
    }

    /// Returns the number of slots in a level's table: a power of two, at most half of them filled.
    pub fn table_slots(&self, level: u32) -> u32 {
        (2 * self.unique_of(level)).next_power_of_two()
    }

    pub fn table_at(&self, level: u32) -> u32 {
        (0..level).map(|l| self.table_slots(l)).sum()
    }
}

/// The buffers of a bake; glsl/technique/voxelized/build.glsl describes their contents.
pub struct Buffers {
    pub state: Buffer,
    /// Read-back of the state after each submission.
    pub state_read: ReadBack,
    ranges: Buffer,
    pub values: Buffer,
    sums: Buffer,
    boundaries: Buffer,
    candidates: Buffer,
    slots: Buffer,
    pub table: Buffer,
    unique: Buffer,
    pub data: Buffer,
    projected: Buffer,
    entries: Buffer,
    pub columns: Buffer,
    shared: Shared,
}

impl Buffers {
    /// Allocates buffers for `room`. With `keep`, they also hold the entries and exits of all columns of a tile. `shared`: buffers that are
    /// kept when capacities grow.
    pub fn new(context: &Context, shape: Shape, room: &Room, merge: bool, keep: bool, shared: &Shared) -> Result<Self> {
        let device = |name: &str, words: u64| Buffer::new(context, name, 4 * words, Memory::Device);
        let values = u64::from(shape.ranks_at()) + 2 * u64::from(room.ranks());
        let candidates = (u64::from(LEAF_WORDS) * u64::from(room.leaf_candidates))
            .max(u64::from(NODE_WORDS) * u64::from(room.node_candidates));
        let columns = u64::from(shape.tile).pow(2);
        let kept_tiles = if room.stays { u64::from(shape.tiles().pow(2)) * shared.tree_count } else { 1 };
        let levels = MAX_LEVELS as u32;
        let triangles = u64::from(shared.triangle_count);
        let seen = if room.stays { triangles * (SEEN_WORDS + BOX_WORDS * shared.tree_count) } else { 0 };
        let projected = PROJECTED_WORDS * (triangles + u64::from(room.pieces)) + seen;
        let top_slots = u64::from(shape.tiles()).pow(3);
        let state = device("voxelized.state", (size_of::<BuildState>() / 4) as u64)?;
        let state_read = ReadBack::new(context, "voxelized.state.read", state.bytes())?;
        Ok(Self {
            state,
            state_read,
            ranges: device("voxelized.ranges", 2 * u64::from(shape.ranks_at()))?,
            values: device("voxelized.values", values)?,
            sums: device("voxelized.sums", values / u64::from(SCANNED) + 1)?,
            boundaries: device("voxelized.boundaries", u64::from(shape.tile_words()) * kept_tiles)?,
            candidates: device("voxelized.candidates", candidates)?,
            slots: device("voxelized.slots", u64::from(room.top_slots_at()) + top_slots)?,
            table: device("voxelized.table", if merge { u64::from(room.table_at(levels)) } else { 1 })?,
            unique: device("voxelized.unique", room.unique_at(levels))?,
            data: device("voxelized.data", u64::from(room.data))?,
            projected: device("voxelized.projected", projected)?,
            entries: device("voxelized.entries", u64::from(room.large) + u64::from(room.entries))?,
            columns: device("voxelized.columns", if keep { 2 * columns } else { 1 })?,
            shared: shared.clone(),
        })
    }

    fn set(&self) -> set::VoxelizedBuild<'_> {
        set::VoxelizedBuild {
            state: &self.state,
            ranges: &self.ranges,
            values: &self.values,
            sums: &self.sums,
            boundaries: &self.boundaries,
            candidates: &self.candidates,
            slots: &self.slots,
            table: &self.table,
            unique_nodes: &self.unique,
            data: &self.data,
            trees: &self.shared.trees,
            triangles: &self.shared.triangles,
            sides: &self.shared.sides,
            projected: &self.projected,
            bin_entries: &self.entries,
            columns: &self.columns,
        }
    }

    pub fn bindings(&self, context: &Context) -> Result<Bindings> {
        self.set().bind(context, "voxelized.build")
    }

    /// Binds these buffers in place of earlier ones.
    pub fn rebind(&self, set: &Bindings) -> Result<()> {
        self.set().resources().iter().enumerate().try_for_each(|(binding, resource)| match resource {
            Resource::Buffer(buffer) => set.replace(binding, buffer),
            _ => Ok(()),
        })
    }

    /// Returns the number of bytes that only a bake needs, without the data of look-ups and of the world.
    pub fn transient_bytes(&self) -> u64 {
        let own = [
            &self.state,
            &self.ranges,
            &self.values,
            &self.sums,
            &self.boundaries,
            &self.candidates,
            &self.slots,
            &self.table,
            &self.unique,
            &self.projected,
            &self.entries,
            &self.columns,
        ];
        own.into_iter().map(Buffer::bytes).sum::<u64>() + self.state_read.bytes()
    }

    /// Returns the initial state of a bake.
    pub fn begin(room: &Room) -> BuildState {
        BuildState {
            entry_capacity: room.entries,
            large_capacity: room.large,
            piece_capacity: room.pieces,
            ..BuildState::default()
        }
    }
}

/// Buffers that stay the same when the other buffers of a bake grow.
#[derive(Clone)]
pub struct Shared {
    pub trees: Buffer,
    pub triangles: Buffer,
    pub sides: Buffer,
    pub triangle_count: u32,
    pub tree_count: u64,
}
