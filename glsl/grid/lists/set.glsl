// Shared by the passes that list each voxel's triangles. Twin: grid::lists.
#ifndef GRID_LISTS_SET_GLSL
#define GRID_LISTS_SET_GLSL
#include "grid/build.glsl"
#include "grid/lists/place.glsl"

// Totals over all lists. Twin: grid::ListTotals.
struct ListTotals {
    uint pairs;       // of a triangle and a voxel that it meets
    uint voxels;      // that any triangle or caster meets, and one more, which stands for all
    uint overflowed;  // 1: more pairs than 32 bits count
};

#ifndef LISTS_ACCESS
#define LISTS_ACCESS
#endif
// A shader that writes pairs defines PAIRS_ACCESS first.
#ifndef PAIRS_ACCESS
#define PAIRS_ACCESS readonly
#endif

// set 1: grid_lists
layout(set = 1, binding = 0, scalar) PAIRS_ACCESS buffer ListsPairs { uvec3 pairs[]; };            // a voxel's bit among all, a triangle, its box there
layout(set = 1, binding = 1, scalar) LISTS_ACCESS buffer ListsWords { uint lists[]; };  // as glsl/grid/lists/place.glsl has them
layout(set = 1, binding = 2, scalar) buffer ListsSums { uint sums[]; };
layout(set = 1, binding = 3, scalar) buffer ListsTotals { ListTotals totals; };
layout(set = 1, binding = 4, scalar) buffer ListsUnsorted { uint unsorted[]; };  // lists in the order in which triangles came

// The longest list that rank.comp sorts; sort.comp sorts longer ones. Any number gives the same lists.
const uint RANKED = 512u;

// The grid's bricks, and one more for the list that all voxels share.
uint brick_count() { return lists_of_all(grid.size) + 1u; }

uvec2 brick_bits(uint brick) {
    return brick == lists_of_all(grid.size) ? uvec2(1u, 0u) : uvec2(grid_bits[2u * brick], grid_bits[2u * brick + 1u]);
}

// Where the start of a voxel's list is stored; `bit`: the number of the voxel's bit among all.
uint lists_start(uint bit) { return lists[bit >> 6] + LIST_WORDS * used_before(brick_bits(bit >> 6), bit & 63u); }

// Where the first list is.
uint lists_begin(uint voxels) { return brick_count() + LIST_WORDS * voxels + 1u; }

// The place in `unsorted` of the entry that is at `at` in `lists`.
uint unsorted_at(uint at) { return (at - lists_begin(totals.voxels)) / LIST_WORDS; }

// Whether there is room for all. Where there is not, nothing is listed.
bool lists_fit(uint voxels) {
    uint room = (lists.length() - brick_count() - 1u) / LIST_WORDS;
    return totals.overflowed == 0u && totals.pairs <= pairs_room && totals.pairs <= room - min(voxels, room);
}
#endif
