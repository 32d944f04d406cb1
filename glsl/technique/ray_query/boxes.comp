#version 460
// Builds a box around each caster. One thread per box. Source: VK_KHR_acceleration_structure. Input: casters. Output: boxes. Twin:
// reference::twin::ray_query. Invariant: a box contains its caster despite rounding; the box of a caster that casts no shadow begins at
// NaN, which makes it inactive.
layout(local_size_x = 64) in;
#include "world/caster.glsl"

layout(push_constant, scalar) uniform BoxesPush {
    uint caster_count;
    uint box_count;
};

// set 0: ray_query_boxes
layout(set = 0, binding = 0, scalar) readonly buffer BoxesCasters { Caster casters[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer BoxesBoxes { float boxes[]; };

// Margin of a box, as a share of its coordinates and radius; it exceeds the accumulated float rounding error.
const float BOX_MARGIN = 1e-5;

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (i >= box_count) {
        return;
    }
    Caster caster = casters[i];
    vec3 end = caster.position + caster_axis(caster);
    precise vec3 margin = caster.radius + BOX_MARGIN * (caster.radius + max(abs(caster.position), abs(end)));
    precise vec3 low = min(caster.position, end) - margin, high = max(caster.position, end) + margin;
    if (i >= caster_count || caster.radius == 0.0) {
        low = vec3(uintBitsToFloat(0x7FC00000u));
    }
    for (uint axis = 0u; axis < 3u; ++axis) {
        boxes[6u * i + axis] = low[axis];
        boxes[6u * i + 3u + axis] = high[axis];
    }
}
