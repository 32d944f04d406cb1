#version 460
// Builds the list of triangles of each used voxel from the pairs. STEP 0 counts each voxel's pairs, STEP 1 appends each pair to its voxel's
// list. A list's start serves as the cursor: in the end it points to the start of the next list. One pair per thread. Source: ours. Inputs:
// pairs, bits, words of bricks. Outputs: counts, then starts and lists. Twin: reference::twin::lists. Invariant: the same triangles in some
// order.
// variants: STEP 0 1
layout(local_size_x = 64) in;
#include "grid/lists/set.glsl"

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (i >= totals.pairs || !lists_fit(totals.voxels)) {
        return;
    }
    uvec3 pair = pairs[i];
    uint at = atomicAdd(lists[lists_start(pair.x) + LIST_WORDS], LIST_WORDS);
    if (STEP == 1) {
        lists[at] = pair.z;
        lists[at + 1u] = pair.y;
        unsorted[unsorted_at(at)] = pair.y;
    }
}
