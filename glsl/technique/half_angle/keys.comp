#version 460
// Computes sort keys: the distance of each caster's centre along the half vector of light and camera, as an integer that sorts in the same
// order. Source: Kniss et al. 2003; Green 2008. Inputs: maps, casters. Output: items, in order of their indices.
// Twin: reference::twin::half_angle::keys.
#include "maps/extents.glsl"
#include "maps/scene.glsl"

struct Item {
    uint key;
    uint index;
};

layout(local_size_x = 64) in;

// set 1: order_keys
layout(set = 1, binding = 0, scalar) writeonly buffer Items { Item items[]; };

layout(push_constant, scalar) uniform HalfPush {
    vec3 half_vector;
    uint count;
};

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (i < count) {
        vec3 middle = casters[i].position + 0.5 * caster_axis(casters[i]) - maps[0].caster_view.origin;
        items[i] = Item(float_order(dot(middle, half_vector)), i);
    }
}
