// Equal nodes share a slot of a hash table. The slot holds the index of a kept node plus 1, or the index of a candidate, marked by the top
// bit. The lowest index among equal nodes wins, so that the choice of kept nodes does not depend on the order of threads.
#ifndef TECHNIQUE_VOXELIZED_MERGE_GLSL
#define TECHNIQUE_VOXELIZED_MERGE_GLSL

const uint EMPTY = 0u;
const uint CANDIDATE = 0x80000000u;

// Returns whether a candidate is the first of its set of equal nodes.
bool is_first(uint candidate) {
    return !MERGE || table[table_at + slots[slots_at + candidate]] == (CANDIDATE | candidate);
}
#endif
