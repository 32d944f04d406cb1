// A stable radix sort of 32-bit keys with an index each, eight bits per round, for all lists at once: maps/order/count.comp,
// maps/order/scan.comp and maps/order/scatter.comp once per digit, from the lowest to the highest. Source: Satish, Harris and Garland 2009,
// Designing Efficient Sorting Algorithms for Manycore GPUs. Twin: maps::order. Items of list l are stored from l · capacity on; a round
// reads one half of the buffer and writes the other.
#ifndef MAPS_ORDER_SORT_GLSL
#define MAPS_ORDER_SORT_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Item {
    uint key;
    uint index;
};

// set 0: order
layout(set = 0, binding = 0, scalar) buffer Items { Item items[]; };
// Number of items of each digit in each block, digit by digit; later, number of these items in earlier blocks. After each digit's blocks:
// number of all items with that digit.
layout(set = 0, binding = 1, scalar) buffer Counts { uint counts[]; };
// Result of the last of four rounds: only the indices.
layout(set = 0, binding = 2, scalar) buffer Sorted { uint sorted[]; };
// With COUNTED, the number of items.
layout(set = 0, binding = 3, scalar) readonly buffer Counted { uint counted[]; };

layout(push_constant, scalar) uniform SortPush {
    uint count;     // number of items per list; with COUNTED there may be fewer
    uint capacity;  // capacity per list, in items
    uint lists;
    uint round;     // 0 to 3
};

// Whether only the device knows the number of items.
CONSTANT(bool, COUNTED, false)

const uint DIGITS = 256u;
const uint SORT_THREADS = 128u;
// Number of items per workgroup; each of its threads processes one at a time.
CONSTANT(uint, SORT_BLOCK, 512u)
const uint BLOCK = SORT_BLOCK;

uint item_count() { return COUNTED ? min(counted[0], count) : count; }
uint blocks() { return (item_count() + BLOCK - 1u) / BLOCK; }
uint block() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint digit(uint key) { return (key >> (8u * round)) & 255u; }
// Index of item `i` of a list before the round, or after it.
uint place(uint list, uint i, bool after) {
    uint half_of = (round & 1u) ^ uint(after);
    return (half_of * lists + list) * capacity + i;
}
uint block_room() { return (capacity + BLOCK - 1u) / BLOCK; }
uint count_place(uint list, uint b, uint d) { return (list * DIGITS + d) * (block_room() + 1u) + b; }
uint total_place(uint list, uint d) { return count_place(list, block_room(), d); }
#endif
