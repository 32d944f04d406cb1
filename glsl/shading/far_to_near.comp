#version 460
// Sort keys of a picture's casters: how far the middle of each lies in front of the camera, as a whole number that falls as the distance
// rises, so that sorted casters come from far to near. Inputs: casters. Output: items, indices rising. Twin: reference::twin::far_to_near.
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
