#version 460
// Computes how many items of each digit are in earlier blocks, and how many there are in all. With few blocks, there is one thread per
// digit; with many, one workgroup per digit, and each of its threads processes a run of blocks. Twin: reference::twin::order::sort. Input
// and output: counts.
#include "maps/order/sort.glsl"

layout(local_size_x = SORT_THREADS) in;

shared uint sums[SORT_THREADS];

// Replaces the count of each block by the sum before it, and returns the total.
uint run(uint list, uint d, uint first, uint end, uint sum) {
    for (uint b = first; b < end; ++b) {
        uint here = counts[count_place(list, b, d)];
        counts[count_place(list, b, d)] = sum;
        sum += here;
    }
    return sum;
}

void main() {
    uint list = gl_WorkGroupID.z, thread = gl_LocalInvocationIndex, last = blocks();
    if (gl_NumWorkGroups.x * SORT_THREADS == DIGITS) {
        uint d = gl_WorkGroupID.x * SORT_THREADS + thread;
        counts[total_place(list, d)] = run(list, d, 0u, last, 0u);
        return;
    }
    uint d = gl_WorkGroupID.x, each = (last + SORT_THREADS - 1u) / SORT_THREADS;
    uint first = min(thread * each, last), end = min(first + each, last);
    uint sum = 0u;
    for (uint b = first; b < end; ++b) {
        sum += counts[count_place(list, b, d)];
    }
    sums[thread] = sum;
    for (uint reach = 1u; reach < SORT_THREADS; reach *= 2u) {
        barrier();
        uint before = thread >= reach ? sums[thread - reach] : 0u;
        barrier();
        sums[thread] += before;
    }
    uint total = run(list, d, first, end, sums[thread] - sum);
    if (thread == SORT_THREADS - 1u) {
        counts[total_place(list, d)] = total;
    }
}
