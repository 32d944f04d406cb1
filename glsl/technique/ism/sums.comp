#version 460
// Computes prefix sums of the triangles' weights in each block. Source: none. Inputs: areas, head. Outputs: sums, blocks. Invariant: sums
// are integers and never decrease. Twin: reference::twin::ism::points.
layout(local_size_x = 128) in;
#include "technique/ism/sample.glsl"

shared uint block[2][BLOCK];

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    if (group >= block_count()) {
        return;
    }
    uint i = group * BLOCK + thread;
    precise float weight = i < triangle_count ? areas[i] * head.scale + 0.5 : 0.0;
    uint from = 0u;
    block[from][thread] = uint(weight);
    barrier();
    for (uint step = 1u; step < BLOCK; step *= 2u) {
        block[1u - from][thread] = block[from][thread] + (thread >= step ? block[from][thread - step] : 0u);
        from = 1u - from;
        barrier();
    }
    if (i < triangle_count) {
        sums[i] = block[from][thread];
    }
    if (thread == 0u) {
        blocks[group] = block[from][BLOCK - 1u];
    }
}
