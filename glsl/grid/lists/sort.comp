#version 460
// The long lists in the order of the triangles, those of 64 voxels by a workgroup, one after the other. Source: Batcher 1968 (a bitonic
// network, all of whose pairs look the same way). Input and output: lists. Twin: reference::twin::lists, which sorts.
layout(local_size_x = 64) in;
#define LISTS_ACCESS coherent
#include "grid/lists/set.glsl"

shared uint long_count;
shared uvec2 longs[64];

void exchange(uint low, uint high) {
    uint a = lists[low], b = lists[high];
    if (a > b) {
        lists[low] = b;
        lists[high] = a;
    }
}

// What has no number of a power of two ends in triangles behind all others, which stay where they are.
void sort(uint begin, uint end) {
    uint count = end - begin, all = 2u << findMSB(count - 1u);
    for (uint block = 2u; block <= all; block *= 2u) {
        for (uint step = block / 2u; step > 0u; step /= 2u) {
            memoryBarrierBuffer();
            barrier();
            for (uint p = gl_LocalInvocationIndex; p < all / 2u; p += 64u) {
                uint low = p / step * 2u * step + p % step;
                // First with the mirror image in the block, then with what is `step` behind.
                uint high = step == block / 2u ? low - low % block + block - 1u - low % block : low + step;
                if (high < count) {
                    exchange(begin + low, begin + high);
                }
            }
        }
    }
}

void main() {
    uint u = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (gl_LocalInvocationIndex == 0u) {
        long_count = 0u;
    }
    barrier();
    if (u < totals.voxels && lists_fit(totals.voxels)) {
        uint begin = lists[brick_count() + u], end = lists[brick_count() + u + 1u];
        if (end - begin > RANKED) {
            longs[atomicAdd(long_count, 1u)] = uvec2(begin, end);
        }
    }
    barrier();
    for (uint l = 0u; l < long_count; ++l) {
        sort(longs[l].x, longs[l].y);
    }
}
