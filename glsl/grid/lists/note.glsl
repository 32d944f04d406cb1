// Records pairs. A pair is a voxel, and a triangle or caster that the voxel lists. A workgroup reserves space for all of its pairs at once.
// Source: ours.
#ifndef GRID_LISTS_NOTE_GLSL
#define GRID_LISTS_NOTE_GLSL
#include "grid/occupy.glsl"
#define PAIRS_ACCESS
#include "grid/lists/box.glsl"
#include "grid/lists/set.glsl"

shared uint group_pairs;
shared uint group_first;

// Reserves space for a thread's `count` pairs and returns the index of the first. All threads of the workgroup must call it.
uint place_of(uint count) {
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        group_pairs = 0u;
    }
    barrier();
    uint at = atomicAdd(group_pairs, count);
    barrier();
    if (gl_LocalInvocationIndex == 0u && group_pairs > 0u) {
        group_first = atomicAdd(totals.pairs, group_pairs);
        if (group_first + group_pairs < group_first) {
            totals.overflowed = 1u;
        }
    }
    barrier();
    return group_first + at;
}

// Marks the voxel as occupied, and records it with the index of the triangle or caster and the part of its bounding box inside the voxel.
void note(uint at, uint number, uvec3 voxel, vec3 low, vec3 high) {
    occupy(voxel);
    if (at < pairs.length()) {
        uint bit = 64u * grid_word(grid.size, 0u, voxel) + grid_bit(0u, voxel);
        pairs[at] = uvec3(bit, number, box_in(low, high, voxel));
    }
}

// Records a caster for all voxels at once; the caster occupies none.
void note_for_all(uint at, uint number) {
    if (at < pairs.length()) {
        pairs[at] = uvec3(64u * lists_of_all(grid.size), number, BOX_GUARDS);
    }
}
#endif
