#version 460
// Writes the casters of each map that touch any tile, in their drawing order. Inputs: marks, blocks, order. Output: drawn.
// Twin: reference::twin::compact::compact.
#include "maps/bins/marks.glsl"

layout(local_size_x = BLOCK_WORDS) in;

void main() {
    uint map = gl_WorkGroupID.z, block = mark_block(), word = gl_LocalInvocationIndex;
    if (block >= mark_blocks()) {
        return;
    }
    uint place = map * capacity + blocks[map * mark_blocks() + block];
    for (uint i = 0u; i < word; ++i) {
        place += bitCount(marks[mark_place(map, block, i)]);
    }
    uint bits = marks[mark_place(map, block, word)];
    uint first = map * capacity + 32u * (block * BLOCK_WORDS + word);
    for (; bits != 0u; bits &= bits - 1u) {
        drawn[place] = order[first + findLSB(bits)];
        ++place;
    }
}
