#version 460
// Fills the holes of maps in global memory, as the last steps of technique/ism/tiled.comp do in shared memory. One workgroup per light.
// Source: as in technique/ism/fill.glsl. Inputs: head, maps. Output: maps. Twin: reference::twin::ism::fill.
#include "technique/ism/atlas.glsl"

CONSTANT(uint, THREADS, 128u)

layout(local_size_x_id = ID_WORKGROUP) in;

uint start;

uint texel_get(uint i) { return maps[start + i]; }
void texel_set(uint i, uint value) { maps[start + i] = value; }
void texel_barrier() {
    memoryBarrierBuffer();
    barrier();
}

#include "technique/ism/fill.glsl"

void main() {
    uint light = GROUP_INDEX, thread = gl_LocalInvocationIndex;
    if (light >= light_count) {
        return;
    }
    start = light * ISM_TEXELS;
    wide_down(thread, THREADS);
    if (ISM_FILL) {
        pull(thread, THREADS, head.radius);
        push(thread, THREADS, head.radius);
    }
}
