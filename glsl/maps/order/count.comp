#version 460
// Counts each block's items by digit. Twin: reference::twin::order::sort. Input: items. Output: counts.
#include "maps/order/sort.glsl"

layout(local_size_x = SORT_THREADS) in;

shared uint tally[DIGITS];

void main() {
    uint list = gl_WorkGroupID.z, b = block(), thread = gl_LocalInvocationIndex;
    if (b >= blocks()) {
        return;
    }
    for (uint d = thread; d < DIGITS; d += SORT_THREADS) {
        tally[d] = 0u;
    }
    barrier();
    for (uint i = b * BLOCK + thread; i < min(item_count(), (b + 1u) * BLOCK); i += SORT_THREADS) {
        atomicAdd(tally[digit(items[place(list, i, false)].key)], 1u);
    }
    barrier();
    for (uint d = thread; d < DIGITS; d += SORT_THREADS) {
        counts[count_place(list, b, d)] = tally[d];
    }
}
