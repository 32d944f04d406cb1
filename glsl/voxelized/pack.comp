#version 460
// Writes kept nodes as look-ups read them (voxelized/walk.glsl). One thread a node. Source: ours, after Kämpe et al. 2016.
// Inputs: kept nodes, sums of sizes. Output: data, which is 0. Twin: reference::twin::voxelized::pack.
layout(local_size_x = 64) in;
#include "voxelized/build.glsl"

void put(uint bit, uint value) {
    uint word = levels[level].at + bit / 32u, shift = bit % 32u;
    if (word + 1u >= data_capacity) {
        return;
    }
    // Nodes begin at half words, so that two may share one.
    atomicOr(data[word], value << shift);
    if (shift > 0u && value >> (32u - shift) != 0u) {
        atomicOr(data[word + 1u], value >> (32u - shift));
    }
}

void main() {
    uint node = 64u * build_group() + gl_LocalInvocationIndex;
    if (failed != 0u || node >= min(levels[level].unique, unique_capacity)) {
        return;
    }
    if (level == 0u) {
        put(64u * node, unique_nodes[unique_at + LEAF_WORDS * node]);
        put(64u * node + 32u, unique_nodes[unique_at + LEAF_WORDS * node + 1u]);
        return;
    }
    uint place = unique_at + NODE_WORDS * node, mask = unique_nodes[place], children = mask_children(mask);
    uint bit = before(rank_at + node) * HEADER_BITS;
    put(bit, mask);
    for (uint c = 0u; c < children; ++c) {
        uint child = unique_nodes[place + 1u + c];
        put(bit + HEADER_BITS + c * levels[level].pointer_bits, level == 1u ? child : before(child_rank_at + child));
    }
}
