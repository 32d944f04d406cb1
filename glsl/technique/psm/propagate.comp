#version 460
// Turns each slice's transmittance into the light left behind it: a running product along each ray, in place, one thread per ray. Source:
// Bavoil and Jansen 2013, Step 3 and Coverage Optimization. Inputs: maps, counts of the bins (COVERAGE_TILES). In and out: volume.
// Invariants: the product is kept in float, so that rounding errors do not accumulate; if no ray of a block of 8×8 hits any caster, these
// rays keep the value that the volume was cleared to, which means full light. With ADDITIVE the volume holds the share of light that is
// lost, so its clear value 0 also means full light. Twin: reference::twin::psm::propagate.
#extension GL_EXT_control_flow_attributes : require
// variants: BITS 8 16
#include "maps/scene.glsl"
#include "technique/psm/constants.glsl"
#include "technique/psm/format.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: psm_rays
layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
// set 2: psm_volume
layout(set = 2, binding = 0, VOLUME_FORMAT) uniform image3D volume;

// Returns whether a caster may cover a ray of this workgroup.
bool covered(uint map) {
    if (COVERAGE == COVERAGE_TILES) {
        uint tile = (map * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
        return counts[tile] > 0u;
    }
    if (COVERAGE == COVERAGE_VIEWPORT) {
        float mark = imageLoad(volume, ivec3(gl_WorkGroupID.xy, map * LAYERS + LAYERS - 1u)).x;
        return mark != (ADDITIVE ? 0.0 : 1.0);
    }
    return true;
}

// Number of layers that are read before the first of them is written: otherwise a ray's reads would wait for its writes one by one.
const uint AHEAD = 8u;

// Turns the transmittances of four slices into the transmittances behind each of them.
vec4 propagated(vec4 slices, float before) {
    if (ADDITIVE) {
        slices.x += before;
        slices.y += slices.x;
        slices.z += slices.y;
        slices.w += slices.z;
    } else {
        slices.x *= before;
        slices.y *= slices.x;
        slices.z *= slices.y;
        slices.w *= slices.z;
    }
    return slices;
}

void main() {
    uint map = gl_WorkGroupID.z;
    ivec3 at = ivec3(gl_GlobalInvocationID.xy, map * LAYERS);
    if (!covered(map) || any(greaterThanEqual(gl_GlobalInvocationID.xy, map_size()))) {
        return;
    }
    float before = ADDITIVE ? 0.0 : 1.0;
    for (uint base = 0u; base < SLICES / 4u; base += AHEAD) {
        vec4 slices[AHEAD];
        [[unroll]] for (uint i = 0u; i < AHEAD; ++i) {
            slices[i] = base + i < SLICES / 4u ? imageLoad(volume, at + ivec3(0, 0, i)) : vec4(0.0);
        }
        [[unroll]] for (uint i = 0u; i < AHEAD; ++i) {
            if (base + i < SLICES / 4u) {
                vec4 behind = propagated(slices[i], before);
                before = behind.w;
                imageStore(volume, at + ivec3(0, 0, i), ADDITIVE ? 1.0 - exp(-behind) : behind);
            }
        }
        at.z += int(AHEAD);
    }
}
