#version 460
// Computes the area of each triangle, and of each block of triangles. Source: none. Inputs: triangles. Outputs: areas, blocks. Invariant: a
// triangle without a finite area counts as having area 0. Twin: reference::twin::ism::points.
layout(local_size_x = 128) in;
#include "technique/ism/sample.glsl"

shared float block[BLOCK];

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    if (group >= block_count()) {
        return;
    }
    uint i = group * BLOCK + thread;
    float area = 0.0;
    if (i < triangle_count) {
        Triangle t = triangles[i];
        area = 0.5 * length(cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]));
        area = area <= FARTHEST ? area : 0.0;
        areas[i] = area;
    }
    block[thread] = area;
    barrier();
    for (uint step = BLOCK / 2u; step > 0u; step /= 2u) {
        if (thread < step) {
            block[thread] += block[thread + step];
        }
        barrier();
    }
    if (thread == 0u) {
        blocks[group] = floatBitsToUint(block[0]);
    }
}
