#version 460
// Sorts each list by the triangles' indices, so that the order in which pairs were recorded does not matter. A triangle's place is the
// number of smaller indices in its list. One pair per thread; glsl/grid/lists/sort.comp sorts long lists. Source: ours. Inputs: pairs,
// bits, starts, unsorted lists. Output: lists. Twin: reference::twin::lists, which sorts.
layout(local_size_x = 64) in;
#include "grid/lists/set.glsl"

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (i >= totals.pairs || !lists_fit(totals.voxels)) {
        return;
    }
    uvec3 pair = pairs[i];
    uint start = lists_start(pair.x), first = lists[start], behind = lists[start + LIST_WORDS];
    uint count = (behind - first) / LIST_WORDS;
    if (count > RANKED) {
        return;
    }
    uint from = unsorted_at(first), rank = 0u;
    for (uint other = from; other < from + count; ++other) {
        rank += uint(unsorted[other] < pair.y);
    }
    lists[first + LIST_WORDS * rank] = pair.z;
    lists[first + LIST_WORDS * rank + 1u] = pair.y;
}
