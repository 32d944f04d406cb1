// Shared by the passes of a bake: buffers, push constants, counts. Twins: technique::voxelized::buffers, reference::twin::voxelized.
//
// Blocks are squares of columns, `side` voxels wide. For each block `ranges` has the least exit and the greatest entry of its columns:
// voxels in front of every exit may be lit, and voxels behind every entry may be shadowed. Only nodes between the least exit and the
// greatest entry need children. So these nodes of a block lie one behind the other, and prefix sums of the blocks' counts number them: no
// pass appends to a list.
#ifndef TECHNIQUE_VOXELIZED_BUILD_GLSL
#define TECHNIQUE_VOXELIZED_BUILD_GLSL
#extension GL_EXT_scalar_block_layout : require
#include "technique/voxelized/tree.glsl"
#include "world/triangle.glsl"

// Twin: BuildPush in technique::voxelized::buffers.
layout(push_constant, scalar) uniform BuildPush {
    uint light;            // which tree
    uint triangle_count;
    uint tile;             // which, row after row
    uint tile_x;           // its first column
    uint tile_y;
    uint width;            // blocks across, of this level, in this tile
    uint bins_at;          // where the counts of bins are in `values`
    uint placed_at;        // and how many of each have been placed
    uint leaves_at;        // where the counts of leaves are in `values`
    uint bricks_at;        // and of bricks, in `ranges` too
    uint scan_at;          // the first of the values to scan
    uint scan_count;       // how many
    uint level;            // 0: leaves (of a scan: bins), 1: bricks, 2: nodes of 16 voxels per side, ...
    uint level_count;      // levels to plan, from that on
    uint leaf_capacity;    // candidates of a level that there is room for
    uint node_capacity;
    uint at;               // where the level's blocks are in `values` and `ranges`
    uint child_at;         // of the level below
    uint child_stride;     // nodes that each of its blocks has room for; 0: they are numbered by `values`
    uint slots_at;
    uint child_slots_at;
    uint rank_at;          // where the ranks of this level's nodes are in `values`
    uint child_rank_at;
    uint unique_at;        // where nodes of this level are kept, in words
    uint unique_capacity;  // how many
    uint table_at;
    uint table_mask;
    uint child_table_at;
    uint data_capacity;    // words
    uint columns_at;       // where the tile's columns are in `boundaries`; in project.comp, those of the light's first tile
    uint mode;             // WHOLE, SEEN and LAST
};

// Twins: Mode in technique::voxelized::buffers.
const uint WHOLE = 1u;  // all columns are found anew; else those in whose block something moves
const uint SEEN = 2u;   // `projected` has where triangles were when they were seen last
const uint LAST = 4u;   // the last tree of a bake: `projected` is updated

// Twin: LevelCounts.
struct LevelCounts {
    uint candidates;    // nodes of this tile, 0 where there is no room for them
    uint demanded;      // nodes that there are, with or without room
    uint base;          // distinct nodes before this tile
    uint unique;        // distinct nodes with this tile's
    uint units;         // units that these take
    uint at;            // where they stand in `data`, words
    uint pointer_bits;  // of their pointers
    uint lost;          // nodes for which the table had no room
    // VkDispatchIndirectCommand: threads of 64 and scans of 1,024, of candidates and of distinct nodes.
    uvec3 groups;
    uvec3 blocks;
    uvec3 unique_groups;
    uvec3 unique_blocks;
};

// set 0: voxelized_build
layout(set = 0, binding = 0, scalar) buffer BuildState {
    LevelCounts levels[15];
    uint entries;        // of bins
    uint large;          // triangles that meet many bins
    uint words;          // of `data`, all trees so far
    uint entry_capacity;
    uint large_capacity;
    uint pieces;         // further pieces of the light's triangles, where clipping by its pyramid leaves more than three corners
    uint moves_wide;     // moved triangles meet more blocks than can be marked: as WHOLE
    uint found;          // blocks whose columns were found in this bake, of all trees
    uint piece_capacity;
    uint failed;         // a buffer was too small: later passes would read unwritten data, and do nothing
};
layout(set = 0, binding = 1, scalar) buffer BuildRanges { uvec2 ranges[]; };      // x: least exit, y: greatest entry
layout(set = 0, binding = 2, scalar) buffer BuildValues { uint values[]; };       // counts, then their sums before each
layout(set = 0, binding = 3, scalar) buffer BuildSums { uint sums[]; };           // of 1,024 values each, likewise
layout(set = 0, binding = 4, scalar) buffer BuildBoundaries { uint boundaries[]; };  // then as technique/voxelized/moves.glsl says
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
layout(set = 0, binding = 15, scalar) buffer BuildColumns { uvec2 columns[]; };   // entry and exit, where they are kept

// Whether equal nodes are merged: a graph; else a tree.
CONSTANT(bool, MERGE, true)

// Values that one workgroup scans.
const uint SCANNED = 1024u;
// Words of a candidate: a leaf's bits; or the mask of a node and the numbers of its children.
const uint LEAF_WORDS = 2u;
const uint NODE_WORDS = 9u;

uint node_words() { return level == 0u ? LEAF_WORDS : NODE_WORDS; }

// Voxels per side of a node of that level; for a leaf, its thickness.
uint level_side(uint of_level) { return 4u << of_level; }

// The sum before value i, after a scan of all.
uint before(uint i) { return values[i] + sums[i / SCANNED]; }

// How many children a mask has.
uint mask_children(uint mask) { return uint(bitCount(mask & (mask >> 1u) & 0x5555u)); }

// The nodes with children in a block of this range: the z at which they begin, in nodes, and how many there are.
uvec2 node_range(uvec2 range, uint side) {
    uint first = range.x / side, end = (range.y + side - 1u) / side;
    return uvec2(first, end > first ? end - first : 0u);
}

uint build_group() { return gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x; }

// Workgroups as dispatches take them: rows of at most 65,535.
uvec3 build_groups(uint count) {
    uint rows = max((count + 65534u) / 65535u, 1u);
    return uvec3((count + rows - 1u) / rows, rows, 1u);
}

void set_unique_groups(uint of_level, uint count) {
    levels[of_level].unique_groups = build_groups((count + 63u) / 64u);
    levels[of_level].unique_blocks = build_groups((count + SCANNED - 1u) / SCANNED);
}
#endif
