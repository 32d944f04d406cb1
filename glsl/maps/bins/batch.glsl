// Fetches a tile's casters in batches, in the view's axes; all threads of a workgroup or subgroup then process each caster. LANES 0: the
// batch is in shared memory. LANES 1: each thread of a subgroup holds one caster and broadcasts it to the other threads. Then no thread
// waits at a barrier, but every subgroup fetches the casters for itself. LANES 1 is for sorted insertion, which skips casters that its
// texels cannot meet, and for software devices, on which threads that read the same memory are serialized. Must be declared before
// inclusion: THREADS, the workgroup's size. May be defined before inclusion: BATCH_SOURCE, by a shader that keeps the entries in a
// different order; BATCH, for a different number of casters per batch.
#ifndef MAPS_BINS_BATCH_GLSL
#define MAPS_BINS_BATCH_GLSL
#include "maps/bins/part.glsl"

#ifndef LANES
#define LANES 0
#endif
#ifndef BATCH_SOURCE
#define BATCH_SOURCE(view, entry) tile_caster(view, entry)
#endif

#if LANES == 1
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require

Caster lane_caster;

uint batch_size() { return gl_SubgroupSize; }

void fetch_batch(View view, uint first, uint filled) {
    uint lane = min(gl_SubgroupInvocationID, filled - 1u);
    lane_caster = BATCH_SOURCE(view, first + lane);
}

Caster batch_caster(uint i) {
    Caster caster;
    caster.position = subgroupBroadcast(lane_caster.position, i);
    caster.radius = subgroupBroadcast(lane_caster.radius, i);
    caster.axis = STRANDS || SPLATS_OR_CELLS || SHEETS ? subgroupBroadcast(lane_caster.axis, i) : vec3(0.0);
    caster.density = subgroupBroadcast(lane_caster.density, i);
    return caster;
}
#else
// Number of casters per batch; smaller on devices with little shared memory.
#ifndef BATCH
#define BATCH 128u
#endif
// Two arrays of four floats: positions and radii, then axes and densities. Threads that read different casters have fewer bank conflicts
// than with both parts of a caster side by side.
shared vec4 batch[2u * BATCH];

uint batch_size() { return BATCH; }

// Fetches `filled` entries from `first` on, 1 to batch_size(). All threads must call it with the same arguments.
void fetch_batch(View view, uint first, uint filled) {
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < filled; i += THREADS) {
        Caster caster = BATCH_SOURCE(view, first + i);
        batch[i] = vec4(caster.position, caster.radius);
        batch[BATCH + i] = vec4(caster.axis, caster.density);
    }
    barrier();
}

// Caster i of the batch; i < filled.
Caster batch_caster(uint i) {
    vec4 ball = batch[i], rest = batch[BATCH + i];
    return Caster(ball.xyz, ball.w, rest.xyz, rest.w);
}
#endif
#endif
