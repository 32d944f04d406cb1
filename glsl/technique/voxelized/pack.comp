#version 460
// Writes kept nodes in the layout that look-ups read (technique/voxelized/walk.glsl). One thread per node. Source: ours, after Kämpe et al.
// 2016. Inputs: kept nodes, sums of sizes. Output: data, cleared to 0 beforehand. Twin: reference::twin::voxelized::pack.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"

// Writes a value at bit `bit` of a word of the level.
void put(uint word, uint bit, uint value) {
    word += levels[level].at + bit / 32u;
    uint shift = bit % 32u;
    if (word + 1u >= data_capacity) {
        return;
    }
    // Nodes begin at half words, so that two may share a word.
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
        put(LEAF_WORDS * node, 0u, unique_nodes[unique_at + LEAF_WORDS * node]);
        put(LEAF_WORDS * node, 32u, unique_nodes[unique_at + LEAF_WORDS * node + 1u]);
        return;
    }
    uint place = unique_at + NODE_WORDS * node, mask = unique_nodes[place], children = mask_children(mask);
    uint unit = before(rank_at + node);
    uint word = HEADER_BITS == 16u ? unit / 2u : unit, bit = HEADER_BITS == 16u ? 16u * (unit & 1u) : 0u;
    put(word, bit, mask);
    for (uint c = 0u; c < children; ++c) {
        uint child = unique_nodes[place + 1u + c];
        put(word, bit + HEADER_BITS + c * levels[level].pointer_bits, level == 1u ? child : before(child_rank_at + child));
    }
}
