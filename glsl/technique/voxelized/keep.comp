#version 460
// Keeps the first of each set of equal nodes, after the nodes of earlier tiles. One thread per candidate. Source: ours. Inputs: candidates,
// ranks. Outputs: kept nodes, table (or slots, if nodes are not merged). Twin: reference::twin::voxelized::merge.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/merge.glsl"

void main() {
    uint node = 64u * build_group() + gl_LocalInvocationIndex;
    if (node >= levels[level].candidates || !is_first(node)) {
        return;
    }
    uint number = levels[level].base + before(rank_at + node), words = node_words();
    if (number < unique_capacity) {
        for (uint w = 0u; w < words; ++w) {
            unique_nodes[unique_at + words * number + w] = candidates[words * node + w];
        }
    }
    if (MERGE) {
        table[table_at + slots[slots_at + node]] = number + 1u;
    } else {
        slots[slots_at + node] = number;
    }
}
