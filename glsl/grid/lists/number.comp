#version 460
// Numbers the used voxels, brick by brick and within a brick in the order of its bits. Stores the number of each brick's first used voxel.
// One workgroup per 1,024 bricks: STEP 0 counts the used voxels of these bricks, STEP 1 adds the counts of all earlier workgroups. Source:
// ours. Inputs: bits, sums. Outputs: the words of bricks, the number of used voxels. Twin: reference::twin::lists. Invariant: if the lists
// exceed their capacity, every voxel gets an empty list.
// variants: STEP 0 1
layout(local_size_x = 128) in;
#include "grid/lists/set.glsl"
#include "grid/lists/scan.glsl"

void main() {
    uint block = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, bricks = brick_count();
    uint blocks = (bricks + SCANNED - 1u) / SCANNED;
    if (block >= blocks) {
        return;
    }
    uint first = SCANNED * block + 8u * gl_LocalInvocationIndex, mine = 0u, all;
    uint before[8];
    for (uint v = 0u; v < 8u; ++v) {
        before[v] = mine;
        if (first + v < bricks) {
            uvec2 bits = brick_bits(first + v);
            mine += uint(bitCount(bits.x) + bitCount(bits.y));
        }
    }
    uint sum = scan_threads(mine, all);
    if (STEP == 0) {
        if (gl_LocalInvocationIndex == 0u) {
            sums[block] = all;
        }
        return;
    }
    sum += scan_range(0u, block);
    uint voxels = scan_range(0u, blocks);
    bool fit = lists_fit(voxels);
    for (uint v = 0u; v < 8u && first + v < bricks; ++v) {
        lists[first + v] = bricks + (fit ? LIST_WORDS * (sum + before[v]) : 0u);
    }
    if (block == 0u && gl_LocalInvocationIndex == 0u) {
        totals.voxels = voxels;
    }
}
