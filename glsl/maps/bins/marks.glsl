// Gathers the casters of a map that touch any tile, in their drawing order, with many workgroups, in three passes. mark sets one bit per
// caster and counts the casters of each block; scan computes where each block's casters begin; compact writes the casters. Each thread
// handles one word of bits. Bound by maps::Compact.
#ifndef MAPS_BINS_MARKS_GLSL
#define MAPS_BINS_MARKS_GLSL
#extension GL_EXT_scalar_block_layout : require

layout(push_constant, scalar) uniform CompactPush {
    uint caster_count;
    uint capacity;  // stride from one map's order to the next, in casters
};

// Number of words of bits per block; a workgroup has one thread for each. Twin: BLOCK_WORDS in reference::twin::compact.
const uint BLOCK_WORDS = 64u;

// set 0: bins_compact
layout(set = 0, binding = 0, scalar) readonly buffer Met { uint met[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
// One bit per caster of a map, in drawing order: whether the caster touches any tile.
layout(set = 0, binding = 2, scalar) buffer Marks { uint marks[]; };
// Number of casters in each block; after scan, the number before each block.
layout(set = 0, binding = 3, scalar) buffer Blocks { uint blocks[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Drawn { uint drawn[]; };
// VkDrawIndirectCommand: vertices, instances, first vertex, first instance.
layout(set = 0, binding = 5, scalar) writeonly buffer Draws { uint draws[]; };

uint mark_blocks() { return (caster_count + 32u * BLOCK_WORDS - 1u) / (32u * BLOCK_WORDS); }

// Index of the block, however the workgroups are spread over two dimensions.
uint mark_block() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }

// Index of word `word` of block `block` of a map.
uint mark_place(uint map, uint block, uint word) { return (map * mark_blocks() + block) * BLOCK_WORDS + word; }
#endif
