#version 460
// Computes the sort keys of a picture's casters: the depth of each caster's centre in front of the camera, as an integer that decreases
// with distance, so that sorted casters go from far to near. Inputs: casters. Output: items, by increasing index.
// Twin: reference::twin::far_to_near.
#include "shading/far_to_near.glsl"

struct Item {
    uint key;
    uint index;
};

layout(local_size_x = 64) in;

// set 0: far_to_near
layout(set = 0, binding = 0, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Items { Item items[]; };

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (i < count) {
        items[i] = Item(far_to_near(casters[i]), i);
    }
}
