#version 460
// Turns what each slice leaves of the light into what is left behind it: the running product along each ray, in place, one
// thread a ray. Source: seed 002 (step 3, coverage). Inputs: maps, counts of the bins (COVERAGE_TILES). In and out: volume.
// Invariants: the product runs in float, so that rounding does not add up; rays whose 8×8 neighbours meet no caster are left
// as they were cleared, which means all of the light. With ADDITIVE what is lost of the light is kept, for the same reason.
// Twin: reference::psm::propagate.
#include "common/light.glsl"
#include "psm/constants.glsl"
#include "psm/format.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 0, VOLUME_FORMAT) uniform image3D volume;

layout(push_constant, scalar) uniform Push { uint map; };

// Whether a caster may cover a ray of this workgroup.
bool covered() {
    if (COVERAGE == COVERAGE_TILES) {
        uint tile = (map * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
        return counts[tile] > 0u;
    }
    if (COVERAGE == COVERAGE_VIEWPORT) {
        float mark = imageLoad(volume, ivec3(gl_WorkGroupID.xy, map * LAYERS + LAYERS - 1u)).x;
        return mark != (ADDITIVE == 1u ? 0.0 : 1.0);
    }
    return true;
}

void main() {
    View view = maps[map].volume;
    ivec3 at = ivec3(gl_GlobalInvocationID.xy, map * LAYERS);
    if (!covered() || any(greaterThanEqual(gl_GlobalInvocationID.xy, uvec2(view.width, view.height)))) {
        return;
    }
    float before = ADDITIVE == 1u ? 0.0 : 1.0;
    for (uint layer = 0u; layer < SLICES / 4u; ++layer, ++at.z) {
        vec4 slices = imageLoad(volume, at);
        if (ADDITIVE == 1u) {
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
        before = slices.w;
        imageStore(volume, at, ADDITIVE == 1u ? 1.0 - exp(-slices) : slices);
    }
}
