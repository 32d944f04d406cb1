// A stable radix sort of 32-bit keys with an index each, eight bits per round, for every map at once: maps/order/count.comp,
// maps/order/scan.comp and maps/order/scatter.comp four times over, from the lowest digit to the highest. Twin: maps::order.
// Keys and indices of map m stand from m · capacity on; a round reads one half of the buffers and writes the other.
#ifndef MAPS_ORDER_SORT_GLSL
#define MAPS_ORDER_SORT_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Item {
    uint key;
    uint index;
};

// set 0: order
layout(set = 0, binding = 0, scalar) buffer Items { Item items[]; };
// How many items each block of each map has per digit; then where the first of them goes.
layout(set = 0, binding = 1, scalar) buffer Counts { uint counts[]; };
// The result: the indices alone.
layout(set = 0, binding = 2, scalar) buffer Sorted { uint sorted[]; };

layout(push_constant, scalar) uniform SortPush {
    uint count;     // items of a map
    uint capacity;  // room of a map
    uint maps;
    uint round;     // 0 to 3
};

const uint DIGITS = 256u;
const uint SORT_THREADS = 128u;
// Items per workgroup; each of its threads takes one at a time.
const uint BLOCK = 1024u;

uint blocks() { return (count + BLOCK - 1u) / BLOCK; }
uint block() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint digit(uint key) { return (key >> (8u * round)) & 255u; }
// Where item `i` of a map stands before the round, or after it.
uint place(uint map, uint i, bool after) {
    uint half_of = (round & 1u) ^ uint(after);
    return (half_of * maps + map) * capacity + i;
}
uint count_place(uint map, uint b, uint d) { return (map * ((capacity + BLOCK - 1u) / BLOCK) + b) * DIGITS + d; }
#endif
