// Shared by the passes that build each voxel's list of triangles. Twin: grid::lists.
#ifndef GRID_LISTS_SET_GLSL
#define GRID_LISTS_SET_GLSL
#include "grid/build.glsl"
#include "grid/lists/place.glsl"

// Totals over all lists. Twin: grid::ListTotals.
struct ListTotals {
    uint pairs;       // number of pairs of a triangle and a voxel that it touches
    uint voxels;      // number of voxels that any triangle or caster touches, plus one for the list that all voxels share
    uint overflowed;  // 1: more pairs than 32 bits can count
};

#ifndef LISTS_ACCESS
#define LISTS_ACCESS
#endif
// A shader that writes pairs defines PAIRS_ACCESS first.
#ifndef PAIRS_ACCESS
#define PAIRS_ACCESS readonly
#endif

// set 1: grid_lists
layout(set = 1, binding = 0, scalar) PAIRS_ACCESS buffer ListsPairs { uvec3 pairs[]; };            // index of the voxel's bit, triangle,
                                                                                                   // its box in the voxel
layout(set = 1, binding = 1, scalar) LISTS_ACCESS buffer ListsWords { uint lists[]; };  // laid out as in glsl/grid/lists/place.glsl
layout(set = 1, binding = 2, scalar) buffer ListsSums { uint sums[]; };
layout(set = 1, binding = 3, scalar) buffer ListsTotals { ListTotals totals; };
layout(set = 1, binding = 4, scalar) buffer ListsUnsorted { uint unsorted[]; };  // lists in the order in which triangles were added

// Length of the longest list that rank.comp sorts; sort.comp sorts longer ones. Other limits give the same lists.
const uint RANKED = 512u;

// Number of bricks in the grid, plus one for the list that all voxels share.
uint brick_count() { return lists_of_all(grid.size) + 1u; }

uvec2 brick_bits(uint brick) {
    return brick == lists_of_all(grid.size) ? uvec2(1u, 0u) : uvec2(grid_bits[2u * brick], grid_bits[2u * brick + 1u]);
}

// Where the start of a voxel's list is stored; `bit`: index of the voxel's bit among the bits of all voxels.
uint lists_start(uint bit) { return lists[bit >> 6] + LIST_WORDS * used_before(brick_bits(bit >> 6), bit & 63u); }

// Where the first list begins.
uint lists_begin(uint voxels) { return brick_count() + LIST_WORDS * voxels + 1u; }

// Index in `unsorted` of the entry at `at` in `lists`.
uint unsorted_at(uint at) { return (at - lists_begin(totals.voxels)) / LIST_WORDS; }

// Whether all pairs and used voxels fit into the buffers. If not, nothing is listed.
bool lists_fit(uint voxels) {
    uint room = (lists.length() - brick_count() - 1u) / LIST_WORDS;
    return totals.overflowed == 0u && totals.pairs <= pairs_room && totals.pairs <= room - min(voxels, room);
}
#endif
