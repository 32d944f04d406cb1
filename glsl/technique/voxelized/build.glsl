// Shared by the passes of a bake: buffers, push constants, counts. Twins: technique::voxelized::buffers, reference::twin::voxelized.
//
// Blocks are squares of columns, `side` voxels wide. For each block, `ranges` holds the least exit and the greatest entry of its columns:
// voxels in front of every exit may be lit, and voxels behind every entry may be shadowed. Only nodes between the least exit and the
// greatest entry need children. A block's nodes are therefore contiguous along z, and prefix sums of the blocks' counts number them: no
// pass appends to a list.
#ifndef TECHNIQUE_VOXELIZED_BUILD_GLSL
#define TECHNIQUE_VOXELIZED_BUILD_GLSL
#extension GL_EXT_scalar_block_layout : require
#include "technique/voxelized/tree.glsl"
#include "world/triangle.glsl"

// Twin: BuildPush in technique::voxelized::buffers.
layout(push_constant, scalar) uniform BuildPush {
    uint light;            // index of the tree
    uint triangle_count;
    uint tile;             // index of the tile, row by row
    uint tile_x;           // first column of the tile
    uint tile_y;
    uint width;            // blocks of this level across the tile
    uint bins_at;          // start of the counts of bins in `values`
    uint placed_at;        // start of the numbers of entries placed in each bin
    uint leaves_at;        // start of the counts of leaves in `values`
    uint bricks_at;        // start of the counts of bricks, in `ranges` too
    uint scan_at;          // first of the values to scan
    uint scan_count;       // number of values to scan
    uint level;            // 0: leaves (in a scan: bins), 1: bricks, 2: nodes of 16 voxels per side, ...
    uint level_count;      // number of levels to plan, from that one on
    uint leaf_capacity;    // capacity for candidates of level 0
    uint node_capacity;    // capacity for candidates of any other level
    uint at;               // start of the level's blocks in `values` and `ranges`
    uint child_at;         // start of the blocks of the level below
    uint child_stride;     // capacity of each of those blocks, in nodes; 0: `values` numbers the nodes
    uint slots_at;
    uint child_slots_at;
    uint rank_at;          // start of the ranks of this level's nodes in `values`
    uint child_rank_at;
    uint unique_at;        // start of this level's kept nodes, in words
    uint unique_capacity;  // capacity for kept nodes
    uint table_at;
    uint table_mask;
    uint child_table_at;
    uint data_capacity;    // capacity of `data`, in words
    uint columns_at;       // start of the tile's columns in `boundaries`; in project.comp, of the light's first tile
    uint mode;             // bits: WHOLE, SEEN and LAST
};

// Twins: Mode in technique::voxelized::buffers.
const uint WHOLE = 1u;  // computes all columns; else only those in whose block something moves
const uint SEEN = 2u;   // `projected` holds where the triangles were last seen
const uint LAST = 4u;   // the last tree of a bake: `projected` is updated

// Twin: LevelCounts.
struct LevelCounts {
    uint candidates;    // number of nodes of this tile, 0 if they exceed the capacity
    uint demanded;      // number of nodes needed, whether or not they fit
    uint base;          // number of distinct nodes before this tile
    uint unique;        // number of distinct nodes including this tile's
    uint units;         // units that these occupy
    uint at;            // where they begin in `data`, in words
    uint pointer_bits;  // bits per pointer
    uint lost;          // number of nodes that did not fit into the table
    // Each a VkDispatchIndirectCommand: groups of 64 threads and scans of 1,024 values, for candidates and for distinct nodes.
    uvec3 groups;
    uvec3 blocks;
    uvec3 unique_groups;
    uvec3 unique_blocks;
};

// set 0: voxelized_build
layout(set = 0, binding = 0, scalar) buffer BuildState {
    LevelCounts levels[15];
    uint entries;        // number of entries of bins
    uint large;          // number of triangles that overlap many bins
    uint words;          // words of `data` used by all trees so far
    uint entry_capacity;
    uint large_capacity;
    uint pieces;         // additional pieces of triangles that have more than three corners after clipping to the light's pyramid
    uint moves_wide;     // moved triangles overlap more blocks than can be marked: same effect as WHOLE
    uint found;          // number of blocks, of all trees, whose columns this bake has computed
    uint piece_capacity;
    uint failed;         // a buffer was too small: later passes do nothing, since they would read unwritten data
};
layout(set = 0, binding = 1, scalar) buffer BuildRanges { uvec2 ranges[]; };      // x: least exit, y: greatest entry
layout(set = 0, binding = 2, scalar) buffer BuildValues { uint values[]; };       // counts, then the sum before each of them
layout(set = 0, binding = 3, scalar) buffer BuildSums { uint sums[]; };           // sums of 1,024 values, then the sum before each
layout(set = 0, binding = 4, scalar) buffer BuildBoundaries { uint boundaries[]; };  // layout: technique/voxelized/moves.glsl
layout(set = 0, binding = 5, scalar) buffer BuildCandidates { uint candidates[]; };
layout(set = 0, binding = 6, scalar) buffer BuildSlots { uint slots[]; };
layout(set = 0, binding = 7, scalar) buffer BuildTable { uint table[]; };
layout(set = 0, binding = 8, scalar) buffer BuildUnique { uint unique_nodes[]; };
layout(set = 0, binding = 9, scalar) buffer BuildData { uint data[]; };
layout(set = 0, binding = 10, scalar) buffer BuildTrees { Tree trees[]; };
layout(set = 0, binding = 11, scalar) readonly buffer BuildTriangles { Triangle triangles[]; };
layout(set = 0, binding = 12, scalar) readonly buffer BuildSides { uint sides[]; };
layout(set = 0, binding = 13, scalar) buffer BuildProjected { int projected[]; };
layout(set = 0, binding = 14, scalar) buffer BuildEntries { uint bin_entries[]; };
layout(set = 0, binding = 15, scalar) buffer BuildColumns { uvec2 columns[]; };   // entry and exit of each column, if they are kept

// Whether equal nodes are merged, which makes the tree a graph.
CONSTANT(bool, MERGE, true)

// Number of values that one workgroup scans.
const uint SCANNED = 1024u;
// Words per candidate: the bits of a leaf; or the mask of a node and the indices of its children.
const uint LEAF_WORDS = 2u;
const uint NODE_WORDS = 9u;

uint node_words() { return level == 0u ? LEAF_WORDS : NODE_WORDS; }

// Returns the voxels per side of a node of a level, which must be above the leaves.
uint level_side(uint of_level) { return 4u << of_level; }

// Returns the sum of all values before value i, after a scan.
uint before(uint i) { return values[i] + sums[i / SCANNED]; }

// Returns how many INTERSECTED children a mask has.
uint mask_children(uint mask) { return uint(bitCount(mask & (mask >> 1u) & 0x5555u)); }

// Returns the nodes with children in a block of this range: the z of the first, in nodes, and their number.
uvec2 node_range(uvec2 range, uint side) {
    uint first = range.x / side, end = (range.y + side - 1u) / side;
    return uvec2(first, end > first ? end - first : 0u);
}

uint build_group() { return gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x; }

// Returns the workgroups of a dispatch: rows of at most 65,535.
uvec3 build_groups(uint count) {
    uint rows = max((count + 65534u) / 65535u, 1u);
    return uvec3((count + rows - 1u) / rows, rows, 1u);
}

void set_unique_groups(uint of_level, uint count) {
    levels[of_level].unique_groups = build_groups((count + 63u) / 64u);
    levels[of_level].unique_blocks = build_groups((count + SCANNED - 1u) / SCANNED);
}
#endif
