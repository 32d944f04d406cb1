// Equal nodes share a slot of a table: in it stands a kept node's number and 1, or a candidate with the top bit set. The least
// number of all that are equal wins, so that what is kept does not depend on which came first.
#ifndef TECHNIQUE_VOXELIZED_MERGE_GLSL
#define TECHNIQUE_VOXELIZED_MERGE_GLSL

const uint EMPTY = 0u;
const uint CANDIDATE = 0x80000000u;

// Whether a candidate is the first of its kind.
bool is_first(uint candidate) {
    return !MERGE || table[table_at + slots[slots_at + candidate]] == (CANDIDATE | candidate);
}
#endif
