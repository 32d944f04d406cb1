#version 460
// Moves each item behind all items of lower digits and behind earlier items of the same digit, so that items with equal keys keep their
// order. Twin: reference::twin::order::sort. Inputs: items, counts. Outputs: items of the next round, or the sorted indices.
#include "maps/order/sort.glsl"

layout(local_size_x = SORT_THREADS) in;

shared uint next[DIGITS];
shared uint digits[SORT_THREADS];

const uint NONE = 0xFFFFFFFFu;

void main() {
    uint map = gl_WorkGroupID.z, b = block(), thread = gl_LocalInvocationIndex;
    if (b >= blocks()) {
        return;
    }
    for (uint d = thread; d < DIGITS; d += SORT_THREADS) {
        next[d] = counts[count_place(map, b, d)];
    }
    for (uint first = b * BLOCK; first < min(count, (b + 1u) * BLOCK); first += SORT_THREADS) {
        uint i = first + thread;
        Item item = Item(0u, 0u);
        uint mine = NONE;
        if (i < count) {
            item = items[place(map, i, false)];
            mine = digit(item.key);
        }
        barrier();
        digits[thread] = mine;
        barrier();
        // How many of the same digit come before, and whether this is the last of them.
        uint before = 0u, after = 0u;
        for (uint j = 0u; j < SORT_THREADS; ++j) {
            uint same = uint(digits[j] == mine);
            before += j < thread ? same : 0u;
            after += j > thread ? same : 0u;
        }
        uint to = mine == NONE ? 0u : next[mine] + before;
        barrier();
        if (mine != NONE) {
            if (after == 0u) {
                next[mine] = to + 1u;
            }
            if (round == 3u) {
                sorted[map * capacity + to] = item.index;
            } else {
                items[place(map, to, true)] = item;
            }
        }
    }
}
