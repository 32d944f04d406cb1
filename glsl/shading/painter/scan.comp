#version 460
// Computes the number of entries of the casters of earlier workgroups, the total, and the length of parts. One workgroup. Input and output:
// sums. Output: totals, with the counters of later passes cleared. Twin: reference::twin::painter.
#include "shading/painter/list_set.glsl"

layout(local_size_x = LIST_THREADS) in;

LIST_SUMS
LIST_TOTALS

shared uint before[LIST_THREADS];

// Sum that saturates at the largest value of a word.
uint add(uint a, uint b) { return a + min(b, ~a); }

void main() {
    uint thread = gl_LocalInvocationIndex, groups = (count + LIST_THREADS - 1u) / LIST_THREADS;
    uint each = (groups + LIST_THREADS - 1u) / LIST_THREADS;
    uint begin = min(thread * each, groups), end = min(begin + each, groups);
    uint own = 0u;
    for (uint i = begin; i < end; ++i) {
        own = add(own, sums[i]);
    }
    before[thread] = own;
    for (uint reach = 1u; reach < LIST_THREADS; reach *= 2u) {
        barrier();
        uint other = thread >= reach ? before[thread - reach] : 0u;
        barrier();
        before[thread] = add(before[thread], other);
    }
    barrier();
    uint sum = thread > 0u ? before[thread - 1u] : 0u;
    for (uint i = begin; i < end; ++i) {
        uint here = sums[i];
        sums[i] = sum;
        sum = add(sum, here);
    }
    if (thread == LIST_THREADS - 1u) {
        uint entries = min(sum, capacity), blocks = (entries + ENTRY_BLOCK - 1u) / ENTRY_BLOCK, rows = (blocks + 65534u) / 65535u;
        totals.entries = entries;
        totals.entry_groups[0] = min(blocks, 65535u);
        totals.entry_groups[1] = max(rows, 1u);
        totals.entry_groups[2] = 1u;
        totals.wanted = sum;
        totals.most_wanted = is_first != 0u ? sum : max(totals.most_wanted, sum);
        totals.sorted = sorted;
        totals.part_entries = max(least_part, (entries + most_parts - 1u) / most_parts);
        totals.slots = 0u;
        totals.parts = 0u;
        totals.part_groups[0] = PART_GROUPS;
        totals.part_groups[1] = 0u;
        totals.part_groups[2] = 1u;
        totals.split = 0u;
        totals.split_groups[0] = PART_GROUPS;
        totals.split_groups[1] = 0u;
        totals.split_groups[2] = 1u;
    }
}
