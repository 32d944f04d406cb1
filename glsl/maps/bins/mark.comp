#version 460
// Marks the casters of each map that touch any tile, in their drawing order, and counts the marked casters of each block.
// Inputs: met, order. Outputs: marks, blocks. Twin: reference::twin::compact::mark.
#include "maps/bins/marks.glsl"

layout(local_size_x = BLOCK_WORDS) in;

shared uint sum;

void main() {
    uint map = gl_WorkGroupID.z, block = mark_block(), word = gl_LocalInvocationIndex;
    if (block >= mark_blocks()) {
        return;
    }
    if (word == 0u) {
        sum = 0u;
    }
    barrier();
    uint first = 32u * (block * BLOCK_WORDS + word), bits = 0u;
    uint count = first < caster_count ? min(caster_count - first, 32u) : 0u;
    for (uint i = 0u; i < count; ++i) {
        bits |= met[map * caster_count + order[map * capacity + first + i]] << i;
    }
    marks[mark_place(map, block, word)] = bits;
    atomicAdd(sum, bitCount(bits));
    barrier();
    if (word == 0u) {
        blocks[map * mark_blocks() + block] = sum;
    }
}
