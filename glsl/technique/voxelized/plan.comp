#version 460
// Counts the nodes of each level of a tile and writes the sizes of the dispatches over these nodes. The dispatches are empty if a level's
// buffer is too small for its nodes. One thread per level. Input: values, sums, after the scan from `at` on. Output: levels. Twin:
// reference::twin::voxelized. `level`: the first level that is planned. `level_count`: number of levels that are planned.
layout(local_size_x = 16) in;
#include "technique/voxelized/build.glsl"

shared uint short_of_room;

void main() {
    uint of_level = level + gl_LocalInvocationIndex;
    bool mine = gl_LocalInvocationIndex < level_count;
    bool failed_before = failed != 0u;
    if (gl_LocalInvocationIndex == 0u) {
        short_of_room = failed;
    }
    barrier();
    // The first region of `values` holds the counts of leaves, one per block of bricks, followed by the counts of bricks, also one per
    // block. The region of each further level has a quarter as many counts as the previous region.
    uint begin = at, across = width;
    for (uint l = level; mine && l < of_level; ++l) {
        begin += across * across;
        across = l == 0u ? across : across / 2u;
    }
    uint nodes = mine ? before(begin + across * across) - before(begin) : 0u;
    if (nodes > (of_level == 0u ? leaf_capacity : node_capacity)) {
        short_of_room = 1u;
    }
    barrier();
    if (!mine) {
        return;
    }
    if (gl_LocalInvocationIndex == 0u) {
        failed = short_of_room;
    }
    levels[of_level].demanded = failed_before ? 0u : max(levels[of_level].demanded, nodes);
    levels[of_level].candidates = short_of_room == 0u ? nodes : 0u;
    levels[of_level].groups = build_groups((levels[of_level].candidates + 63u) / 64u);
    levels[of_level].blocks = build_groups((levels[of_level].candidates + SCANNED - 1u) / SCANNED);
}
