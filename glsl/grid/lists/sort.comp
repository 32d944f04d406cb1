#version 460
// Sorts the long lists by the triangles' indices: a workgroup sorts the lists of its 64 voxels one by one. Then finds the box about each
// list, one list per thread. Source: Batcher 1968 (a bitonic network in which all comparisons have the same direction). Input and output:
// lists. Twin: reference::twin::lists, which sorts.
layout(local_size_x = 64) in;
#define LISTS_ACCESS coherent
#include "grid/lists/box.glsl"
#include "grid/lists/set.glsl"

shared uint long_count;
shared uvec2 longs[64];

// `low` and `high` count entries, not words.
void exchange(uint begin, uint low, uint high) {
    low = begin + LIST_WORDS * low;
    high = begin + LIST_WORDS * high;
    uvec2 a = uvec2(lists[low], lists[low + 1u]), b = uvec2(lists[high], lists[high + 1u]);
    if (a.y > b.y) {
        lists[low] = b.x;
        lists[low + 1u] = b.y;
        lists[high] = a.x;
        lists[high + 1u] = a.y;
    }
}

// If the count is not a power of two, the list is sorted as if it were padded with greater indices, which never move.
void sort(uint begin, uint end) {
    uint count = (end - begin) / LIST_WORDS, all = 2u << findMSB(count - 1u);
    for (uint block = 2u; block <= all; block *= 2u) {
        for (uint step = block / 2u; step > 0u; step /= 2u) {
            memoryBarrierBuffer();
            barrier();
            for (uint p = gl_LocalInvocationIndex; p < all / 2u; p += 64u) {
                uint low = p / step * 2u * step + p % step;
                // An entry is first compared with its mirror image in the block, later with the entry `step` after it.
                uint high = step == block / 2u ? low - low % block + block - 1u - low % block : low + step;
                if (high < count) {
                    exchange(begin, low, high);
                }
            }
        }
    }
}

// Reads four words at a time, so as to wait only once for all four.
uint box_of_list(uint begin, uint end) {
    uint last = end - LIST_WORDS, box = lists[last];
    for (uint at = begin; at < last; at += 4u * LIST_WORDS) {
        uint a = lists[at], b = lists[min(at + LIST_WORDS, last)];
        uint c = lists[min(at + 2u * LIST_WORDS, last)], d = lists[min(at + 3u * LIST_WORDS, last)];
        box = box_about(box, box_about(box_about(a, b), box_about(c, d)));
    }
    return box;
}

void main() {
    uint u = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (gl_LocalInvocationIndex == 0u) {
        long_count = 0u;
    }
    barrier();
    bool is_used = u < totals.voxels && lists_fit(totals.voxels);
    uint start = brick_count() + LIST_WORDS * u, begin = 0u, end = 0u;
    if (is_used) {
        begin = lists[start];
        end = lists[start + LIST_WORDS];
        if (end - begin > LIST_WORDS * RANKED) {
            longs[atomicAdd(long_count, 1u)] = uvec2(begin, end);
        }
    }
    barrier();
    for (uint l = 0u; l < long_count; ++l) {
        sort(longs[l].x, longs[l].y);
    }
    memoryBarrierBuffer();
    barrier();
    if (is_used) {
        // The list that all voxels share may be empty.
        lists[start + 1u] = begin < end ? box_of_list(begin, end) : 0u;
    }
}
