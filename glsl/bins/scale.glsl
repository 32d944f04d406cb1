// The unit in which a workgroup adds up its tile's optical depths as whole numbers. Needs, declared before: THREADS, of a
// workgroup.
#ifndef BINS_SCALE_GLSL
#define BINS_SCALE_GLSL
#include "bins/part.glsl"
#include "bins/sums.glsl"

shared uint tile_bound;

// Units an optical depth of 1. All threads of the workgroup call it alike.
float tile_scale(TilePart part) {
    if (gl_LocalInvocationIndex == 0u) {
        tile_bound = 0u;
    }
    barrier();
    uint most = 0u;
    for (uint i = gl_LocalInvocationIndex; i < part.count; i += THREADS) {
        most += caster_bound(casters[entries[part.first + i].y], DARK);
    }
    atomicAdd(tile_bound, most);
    barrier();
    return sum_scale(max(tile_bound, 1u));
}
#endif
