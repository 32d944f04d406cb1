#version 460
// Moves each item behind all items with lower digits and behind earlier items with the same digit, so that items with equal keys keep their
// order. Twin: reference::twin::order::sort. Inputs: items, counts. Outputs: items of the next round, or the sorted indices; with COUNTED
// always items.
// variants: BALLOTS 0 1
#if BALLOTS == 1
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#endif
#include "maps/order/sort.glsl"

layout(local_size_x = SORT_THREADS) in;

// Whether one thread of a workgroup moves all items of the block: faster on devices whose threads do not run in parallel anyway.
CONSTANT(bool, SERIAL, false)

shared uint next[DIGITS];
shared uint digits[SORT_THREADS];

const uint NONE = 0xFFFFFFFFu;

#if BALLOTS == 1
// The threads of a subgroup that hold the digit `mine`, which is NONE for threads without an item.
uvec4 with_digit(uint mine) {
    uvec4 same = subgroupBallot(mine != NONE);
    for (uint bit = 0u; bit < 8u; ++bit) {
        bool is_set = bitfieldExtract(mine, int(bit), 1) != 0u;
        uvec4 has = subgroupBallot(is_set);
        same &= is_set ? has : ~has;
    }
    return same;
}
#endif

void put(uint list, uint to, Item item) {
    if (round == 3u && !COUNTED) {
        sorted[list * capacity + to] = item.index;
    } else {
        items[place(list, to, true)] = item;
    }
}

// Computes the index to which the block's first item of each digit moves.
void find_first(uint list, uint b, uint thread) {
    // Each thread sums two adjacent digits.
    uint of_low = counts[total_place(list, 2u * thread)];
    uint pair = of_low + counts[total_place(list, 2u * thread + 1u)];
    digits[thread] = pair;
    for (uint reach = 1u; reach < SORT_THREADS; reach *= 2u) {
        barrier();
        uint before = thread >= reach ? digits[thread - reach] : 0u;
        barrier();
        digits[thread] += before;
    }
    uint before = digits[thread] - pair;
    next[2u * thread] = before + counts[count_place(list, b, 2u * thread)];
    next[2u * thread + 1u] = before + of_low + counts[count_place(list, b, 2u * thread + 1u)];
}

void main() {
#if BALLOTS == 1
    uint thread = gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID;
#else
    uint thread = gl_LocalInvocationIndex;
#endif
    uint list = gl_WorkGroupID.z, b = block();
    if (b >= blocks()) {
        return;
    }
    find_first(list, b, thread);
    uint end = min(item_count(), (b + 1u) * BLOCK);
    if (SERIAL) {
        barrier();
        for (uint i = b * BLOCK; thread == 0u && i < end; ++i) {
            Item item = items[place(list, i, false)];
            put(list, next[digit(item.key)]++, item);
        }
        return;
    }
    for (uint first = b * BLOCK; first < end; first += SORT_THREADS) {
        uint i = first + thread;
        Item item = Item(0u, 0u);
        uint mine = NONE;
        if (i < end) {
            item = items[place(list, i, false)];
            mine = digit(item.key);
        }
#if BALLOTS == 1
        uvec4 same = with_digit(mine);
        uint before = subgroupBallotExclusiveBitCount(same), to = 0u;
        bool is_last = before + 1u == subgroupBallotBitCount(same);
        // One subgroup runs at a time, so that items with equal digits keep their order.
        for (uint subgroup = 0u; subgroup < gl_NumSubgroups; ++subgroup) {
            barrier();
            if (subgroup == gl_SubgroupID && mine != NONE) {
                to = next[mine] + before;
            }
            subgroupBarrier();
            if (subgroup == gl_SubgroupID && mine != NONE && is_last) {
                next[mine] = to + 1u;
            }
        }
        if (mine != NONE) {
            put(list, to, item);
        }
#else
        barrier();
        digits[thread] = mine;
        barrier();
        // Number of items with the same digit before this one, and number after it.
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
            put(list, to, item);
        }
#endif
    }
}
