#version 460
// Computes how much light from each texel's patch reaches the points that the camera sees, which is its importance, and each row's flux,
// with and without this weight. One workgroup per row. Inputs: points, maps, triangles, lights, fluxes. Outputs: importances, row_fluxes.
// Twin: reference::twin::indirect::importance.
#include "lights/indirect/drawn.glsl"
#include "lights/indirect/patch.glsl"
#include "lights/indirect/weighed.glsl"

const uint THREADS = 64u;
layout(local_size_x = THREADS) in;

layout(push_constant, scalar) uniform SumsPush { uint row_count; };

shared ViewPoint points[POINTS];
shared vec2 sums_of[THREADS];

void main() {
    uint row = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, thread = gl_LocalInvocationIndex;
    for (uint i = thread; i < POINTS; i += THREADS) {
        points[i] = view_points[i];
    }
    barrier();
    vec2 mine = vec2(0.0);
    if (row < row_count) {
        for (uint i = thread; i < SIDE; i += THREADS) {
            uint texel = row * SIDE + i;
            float flux = fluxes[texel], importance = 0.0;
            if (flux > 0.0) {
                Patch lit = patch_of(texel);
                float area = patch_area(lit);
                for (uint p = 0u; p < POINTS; ++p) {
                    importance += light_to(points[p], lit.position, lit.normal, area);
                }
            }
            importances[texel] = importance;
            mine += flux * vec2(1.0, importance);
        }
    }
    sums_of[thread] = mine;
    barrier();
    // Always in the same order, so that every run produces the same bits.
    for (uint half_count = THREADS / 2u; half_count > 0u; half_count /= 2u) {
        if (thread < half_count) {
            sums_of[thread] += sums_of[thread + half_count];
        }
        barrier();
    }
    if (thread == 0u && row < row_count) {
        row_fluxes[row] = sums_of[0];
    }
}
