#version 460
// Units of flux of each block of texels. A workgroup a block. Inputs: fluxes, the greatest. Output: sums. Twin:
// reference::twin::indirect::sums.
#include "indirect/drawn.glsl"

const uint THREADS = 64u;
layout(local_size_x = THREADS) in;

layout(push_constant, scalar) uniform SumsPush { uint block_count; };

shared uint total;

void main() {
    uint block = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (gl_LocalInvocationIndex == 0u) {
        total = 0u;
    }
    barrier();
    if (block < block_count) {
        uint mine = 0u;
        for (uint i = gl_LocalInvocationIndex; i < BLOCK; i += THREADS) {
            mine += flux_units(fluxes[block * BLOCK + i], greatest);
        }
        atomicAdd(total, mine);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && block < block_count) {
        sums[block] = total;
    }
}
