// A stable radix sort of 32-bit keys with an index each, eight bits per round, for every list at once: maps/order/count.comp,
// maps/order/scan.comp and maps/order/scatter.comp once per digit, from the lowest to the highest. Source: Satish, Harris and Garland 2009,
// Designing Efficient Sorting Algorithms for Manycore GPUs. Twin: maps::order. Items of list l stand from l · capacity on; a round reads
// one half of the buffer and writes the other.
#ifndef MAPS_ORDER_SORT_GLSL
#define MAPS_ORDER_SORT_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Item {
    uint key;
    uint index;
};

// set 0: order
layout(set = 0, binding = 0, scalar) buffer Items { Item items[]; };
// How many items of each digit each block has, digit after digit; then how many of them stand in earlier blocks. Behind each digit's
// blocks: how many items have the digit.
layout(set = 0, binding = 1, scalar) buffer Counts { uint counts[]; };
// The result of the last of four rounds: the indices alone.
layout(set = 0, binding = 2, scalar) buffer Sorted { uint sorted[]; };
// With COUNTED, the number of items.
layout(set = 0, binding = 3, scalar) readonly buffer Counted { uint counted[]; };

layout(push_constant, scalar) uniform SortPush {
    uint count;     // items of a list; with COUNTED there may be fewer
    uint capacity;  // room of a list
    uint lists;
    uint round;     // 0 to 3
};

// Whether only the device knows how many items there are.
CONSTANT(bool, COUNTED, false)

const uint DIGITS = 256u;
const uint SORT_THREADS = 128u;
// Items per workgroup; each of its threads takes one at a time.
CONSTANT(uint, SORT_BLOCK, 512u)
const uint BLOCK = SORT_BLOCK;

uint item_count() { return COUNTED ? min(counted[0], count) : count; }
uint blocks() { return (item_count() + BLOCK - 1u) / BLOCK; }
uint block() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint digit(uint key) { return (key >> (8u * round)) & 255u; }
// Where item `i` of a list stands before the round, or after it.
uint place(uint list, uint i, bool after) {
    uint half_of = (round & 1u) ^ uint(after);
    return (half_of * lists + list) * capacity + i;
}
uint block_room() { return (capacity + BLOCK - 1u) / BLOCK; }
uint count_place(uint list, uint b, uint d) { return (list * DIGITS + d) * (block_room() + 1u) + b; }
uint total_place(uint list, uint d) { return count_place(list, block_room(), d); }
#endif
