#version 460
// Completes a light's tree: the kind of its root, and where its levels begin. One thread. Source: ours. Inputs: ranges and slots of the top
// level, levels, sums of sizes. Output: trees. Twin: reference::twin::voxelized::pack.
layout(local_size_x = 1) in;
#include "technique/voxelized/build.glsl"

void main() {
    uvec2 range = ranges[at];
    bool nodes = node_range(range, level_side(level)).y > 0u;
    trees[light].root = nodes ? INTERSECTED : range.x >= trees[light].size ? LIT : SHADOWED;
    trees[light].root_at = 0u;
    if (nodes && failed == 0u) {
        uint slot = slots[slots_at];
        trees[light].root_at = before(rank_at + (MERGE ? table[table_at + slot] - 1u : slot));
    }
    trees[light].shortcuts = words;
    words += 1u << 3u * shortcut_bits(trees[light].levels);
    for (uint l = 0u; l <= level; ++l) {
        trees[light].at[l] = levels[l].at;
        trees[light].pointer_bits[l] = levels[l].pointer_bits;
    }
}
