#version 460
// Computes the mean importance of all flux, which a test compares with f64. One workgroup. Input: row_fluxes. Output: mean_importance.
#include "lights/indirect/weighed.glsl"

const uint THREADS = 128u;
layout(local_size_x = THREADS) in;

layout(push_constant, scalar) uniform SumsPush { uint row_count; };

shared vec2 sums_of[THREADS];

void main() {
    uint thread = gl_LocalInvocationIndex;
    vec2 mine = vec2(0.0);
    for (uint row = thread; row < row_count; row += THREADS) {
        mine += row_fluxes[row];
    }
    sums_of[thread] = mine;
    barrier();
    for (uint half_count = THREADS / 2u; half_count > 0u; half_count /= 2u) {
        if (thread < half_count) {
            sums_of[thread] += sums_of[thread + half_count];
        }
        barrier();
    }
    if (thread == 0u) {
        mean_importance = sums_of[0].x > 0.0 ? sums_of[0].y / sums_of[0].x : 0.0;
    }
}
