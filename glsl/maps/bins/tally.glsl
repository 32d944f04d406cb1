// Selects the casters that a thread of count.comp or scatter.comp handles, and counts them per workgroup in shared memory. TALLY, defined
// before inclusion, enables the counting.
#ifndef MAPS_BINS_TALLY_GLSL
#define MAPS_BINS_TALLY_GLSL
#include "maps/bins/tiles.glsl"

#if TALLY == 1
// The host chooses the workgroup's size and TALLY_TURNS, within the device's limits.
layout(local_size_x_id = ID_TALLY_THREADS) in;
CONSTANT(uint, TALLY_THREADS, 128u)
// Number of casters that a thread handles, one after another.
CONSTANT(uint, TALLY_TURNS, 8u)
// One word per tile of a map, which has at most this many tiles. Twin: MOST_TALLIED in maps::threads.
shared uint tally[4096];
#else
const uint TALLY_THREADS = BIN_THREADS;
const uint TALLY_TURNS = 1u;
layout(local_size_x = TALLY_THREADS) in;
#endif

// Index of the thread among those that share a caster.
uint tally_lane() { return gl_LocalInvocationIndex % TILE_LANES; }

// Index of a thread's caster in a turn; it may be past the last caster.
uint tally_caster(uint turn) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return ((group * TALLY_TURNS + turn) * TALLY_THREADS + gl_LocalInvocationIndex) / TILE_LANES;
}

void tally_clear(uvec2 tiles) {
#if TALLY == 1
    for (uint i = gl_LocalInvocationIndex; i < tiles.x * tiles.y; i += TALLY_THREADS) {
        tally[i] = 0u;
    }
    barrier();
#endif
}
#endif
