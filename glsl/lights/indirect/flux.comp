#version 460
// Computes the flux that leaves each texel's patch, as luminance, and the greatest flux of all texels. Inputs: maps, triangles, lights.
// Outputs: fluxes; the greatest flux. Twin: reference::twin::indirect::patch.
#include "lights/indirect/drawn.glsl"
#include "lights/indirect/patch.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform FluxPush { uint texel_count; };

shared uint most;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        most = 0u;
    }
    barrier();
    uint texel = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (texel < texel_count) {
        float flux = counted(luminance(patch_of(texel).flux));
        fluxes[texel] = flux;
        atomicMax(most, floatBitsToUint(flux));
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicMax(greatest, most);
    }
}
