// A tile's casters, a batch at a time, in the view's axes; each is looked at by all threads of a workgroup or subgroup alike. LANES 0: the
// batch stands in shared memory. LANES 1: each thread of a subgroup keeps one caster, which it shows the others; there is no wait, and
// every subgroup fetches the casters for itself. That is for sorted insertion, which skips casters that its texels cannot meet, and for
// software devices, on which threads that read one place in memory do so one after the other. Needs, declared before: THREADS, of a
// workgroup. A shader that keeps the entries in another order defines BATCH_SOURCE before; one that wants another number of casters per
// batch, BATCH.
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
    caster.axis = STRANDS || GAUSSIANS ? subgroupBroadcast(lane_caster.axis, i) : vec3(0.0);
    caster.density = subgroupBroadcast(lane_caster.density, i);
    return caster;
}
#else
// For devices of little memory fewer.
#ifndef BATCH
#define BATCH 128u
#endif
// Four floats each: positions and radii, then axes and densities. Threads that look at casters of their own meet in fewer banks than
// if both stood side by side.
shared vec4 batch[2u * BATCH];

uint batch_size() { return BATCH; }

// Entries first, first + 1, …, as many as `filled`, of which there are 1 to batch_size(). All threads call it alike.
void fetch_batch(View view, uint first, uint filled) {
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < filled; i += THREADS) {
        Caster caster = BATCH_SOURCE(view, first + i);
        batch[i] = vec4(caster.position, caster.radius);
        batch[BATCH + i] = vec4(caster.axis, caster.density);
    }
    barrier();
}

// Caster i < filled.
Caster batch_caster(uint i) {
    vec4 ball = batch[i], rest = batch[BATCH + i];
    return Caster(ball.xyz, ball.w, rest.xyz, rest.w);
}
#endif
#endif
