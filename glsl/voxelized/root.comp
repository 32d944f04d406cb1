#version 460
// Completes a light's tree: what its root is, and where its levels stand. One thread. Source: ours. Inputs: ranges and slots of the
// top level, levels, sums of sizes. Output: trees. Twin: reference::twin::voxelized::pack.
layout(local_size_x = 1) in;
#include "voxelized/build.glsl"

void main() {
    uvec2 range = ranges[at];
    bool nodes = node_range(range, level_side(level)).y > 0u;
    trees[light].root = nodes ? INTERSECTED : range.x >= trees[light].size ? LIT : SHADOWED;
    uint slot = slots[slots_at];
    uint number = MERGE ? table[table_at + slot] - 1u : slot;
    trees[light].root_at = nodes ? before(rank_at + number) : 0u;
    for (uint l = 0u; l <= level; ++l) {
        trees[light].at[l] = levels[l].at;
        trees[light].pointer_bits[l] = levels[l].pointer_bits;
    }
}
