#version 460
// Computes where the list of each used voxel starts, from the triangles' counts. One workgroup per 1,024 voxels: STEP 0 sums the counts of
// these voxels, STEP 1 adds the sums of all earlier workgroups. A list's start is stored as the cursor at which fill.comp appends: it
// advances to the list's end, where the next list starts. Source: ours. Input: counts. Output: starts. Twin: reference::twin::lists.
// variants: STEP 0 1
layout(local_size_x = 128) in;
#include "grid/lists/set.glsl"
#include "grid/lists/scan.glsl"

void main() {
    uint block = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, voxels = totals.voxels;
    if (block >= max(1u, (voxels + SCANNED - 1u) / SCANNED) || !lists_fit(voxels)) {
        return;
    }
    uint bricks = brick_count(), first = SCANNED * block + 8u * gl_LocalInvocationIndex, mine = 0u, all;
    uint before[8];
    for (uint v = 0u; v < 8u; ++v) {
        before[v] = mine;
        mine += first + v < voxels ? lists[bricks + LIST_WORDS * (first + v + 1u)] : 0u;
    }
    uint sum = scan_threads(mine, all);
    if (STEP == 0) {
        if (gl_LocalInvocationIndex == 0u) {
            sums[block] = all;
        }
        return;
    }
    uint start = lists_begin(voxels);
    sum += start + scan_range(0u, block);
    for (uint v = 0u; v < 8u && first + v < voxels; ++v) {
        lists[bricks + LIST_WORDS * (first + v + 1u)] = sum + before[v];
    }
    if (block == 0u && gl_LocalInvocationIndex == 0u) {
        lists[bricks] = start;
    }
}
