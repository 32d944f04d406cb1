#version 460
// Weights each texel's flux by how much of it reaches the points that the camera sees. Inputs: importances, mean_importance. Outputs:
// fluxes, the greatest flux. Twin: reference::twin::indirect::weight. Source: Ritschel et al. 2011, Making imperfect shadow maps
// view-adaptive; drawing a share by flux alone: Veach and Guibas 1995 (defensive sampling).
#include "lights/indirect/drawn.glsl"
#include "lights/indirect/weighed.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform FluxPush { uint texel_count; };

// Share of virtual lights that are drawn by flux alone, so that no light is more than 1 / BY_FLUX times as bright as if all were. Twin:
// reference::twin::indirect.
const float BY_FLUX = 0.25;

shared uint most;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        most = 0u;
    }
    barrier();
    uint texel = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (texel < texel_count) {
        // If no light reaches the points that the camera sees, all texels are weighted by flux alone.
        float by_view = mean_importance > 0.0 ? importances[texel] / mean_importance : 1.0;
        float weight = counted(fluxes[texel] * (BY_FLUX + (1.0 - BY_FLUX) * by_view));
        fluxes[texel] = weight;
        atomicMax(most, floatBitsToUint(weight));
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicMax(greatest, most);
    }
}
