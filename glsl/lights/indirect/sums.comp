#version 460
// Sums the units of flux in each row of texels of a map. One workgroup per row. Inputs: fluxes, the greatest flux. Output: sums. Twin:
// reference::twin::indirect::sums.
#include "lights/indirect/drawn.glsl"

const uint THREADS = 64u;
layout(local_size_x = THREADS) in;

layout(push_constant, scalar) uniform SumsPush { uint row_count; };

shared uint total;

void main() {
    uint row = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (gl_LocalInvocationIndex == 0u) {
        total = 0u;
    }
    barrier();
    if (row < row_count) {
        uint mine = 0u;
        for (uint i = gl_LocalInvocationIndex; i < SIDE; i += THREADS) {
            mine += flux_units(fluxes[row * SIDE + i], greatest);
        }
        atomicAdd(total, mine);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && row < row_count) {
        sums[row] = total;
    }
}
