// Chooses the unit in which a workgroup sums its tile's optical depths as integers. Must be declared before inclusion: THREADS, the
// workgroup's size.
#ifndef MAPS_BINS_SCALE_GLSL
#define MAPS_BINS_SCALE_GLSL
#include "maps/bins/part.glsl"
#include "maps/bins/sums.glsl"

shared uint tile_bound[2];

// Number of units per optical depth of 1. All threads of the workgroup must call it.
float tile_scale(TilePart part) {
    if (gl_LocalInvocationIndex == 0u) {
        tile_bound[0] = tile_bound[1] = 0u;
    }
    barrier();
    uvec2 most = uvec2(0u);
    for (uint i = gl_LocalInvocationIndex; i < part.count; i += THREADS) {
        wide_add(most, entry_bound(entries[part.first + i], DARK));
    }
    WIDE_ATOMIC_ADD(tile_bound[0], tile_bound[1], most);
    barrier();
    return sum_scale(uvec2(tile_bound[0], tile_bound[1]));
}
#endif
