#version 460
// Computes prefix sums of the rows' units of flux, and their total. One workgroup. Input: sums. Output: starts. Twin:
// reference::twin::indirect::scan.
#include "lights/indirect/drawn.glsl"

const uint THREADS = 128u;
layout(local_size_x = THREADS) in;

layout(push_constant, scalar) uniform SumsPush { uint row_count; };

shared uvec2 before[THREADS];

void main() {
    uint thread = gl_LocalInvocationIndex;
    uint share = (row_count + THREADS - 1u) / THREADS;
    uint begin = min(thread * share, row_count), end = min(begin + share, row_count);
    uvec2 mine = uvec2(0u);
    for (uint row = begin; row < end; ++row) {
        mine = add(mine, uvec2(sums[row], 0u));
    }
    before[thread] = mine;
    barrier();
    // There are so few sums that a serial loop costs less than the barriers of a parallel scan.
    if (thread == 0u) {
        uvec2 sum = uvec2(0u);
        for (uint t = 0u; t < THREADS; ++t) {
            uvec2 here = before[t];
            before[t] = sum;
            sum = add(sum, here);
        }
        starts[row_count] = sum;
    }
    barrier();
    uvec2 sum = before[thread];
    for (uint row = begin; row < end; ++row) {
        starts[row] = sum;
        sum = add(sum, uvec2(sums[row], 0u));
    }
}
