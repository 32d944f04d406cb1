#version 460
// Computes the size of each kept node, in units, and the sum of the sizes before each node. In a graph, a node has 16 bits for the mask,
// and pointers with as many bits as the level below needs, in units of 16 bits; in a tree, one word for the mask and one per pointer.
// Leaves are addressed by index. Source: ours. Inputs: kept nodes. Outputs: values from rank_at on, sums, pointer_bits.
// Twin: reference::twin::voxelized::pack.
layout(local_size_x = 128) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/scan.glsl"

// Returns how many bits numbers below `end` need.
uint bits_below(uint end) { return end > 1u ? uint(findMSB(end - 1u)) + 1u : 1u; }

uint pointer_bits() {
    return HEADER_BITS == 32u ? 32u : bits_below(level == 1u ? levels[0].unique : levels[level - 1u].units);
}

uint value_of(uint i) {
    uint node = i - rank_at;
    if (node >= min(levels[level].unique, unique_capacity)) {
        return 0u;
    }
    uint bits = HEADER_BITS + mask_children(unique_nodes[unique_at + NODE_WORDS * node]) * pointer_bits();
    return (bits + HEADER_BITS - 1u) / HEADER_BITS;
}

void main() {
    if (failed != 0u) {
        return;
    }
    if (build_group() < (levels[level].unique + SCANNED - 1u) / SCANNED) {
        uint first = rank_at + SCANNED * build_group();
        SCAN_BLOCK(first, value_of)
    }
    if (build_group() == 0u && gl_LocalInvocationIndex == 0u) {
        levels[level].pointer_bits = pointer_bits();
    }
}
