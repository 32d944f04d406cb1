#version 460
// Computes the depth at which each caster begins in each map's view, as an integer that compares in the same order.
// Twin: reference::twin::order::keys. Inputs: maps, casters. Output: items, by increasing index.
#include "maps/extents.glsl"
#include "maps/scene.glsl"

struct Item {
    uint key;
    uint index;
};

layout(local_size_x = 64) in;

// set 1: order_keys
layout(set = 1, binding = 0, scalar) writeonly buffer Items { Item items[]; };

layout(push_constant, scalar) uniform KeysPush {
    uint count;
    uint capacity;  // capacity per map, in items
};

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (i >= count) {
        return;
    }
    View view = maps[gl_WorkGroupID.z].caster_view;
    Caster caster = casters[i];
    float start = dot(caster.position - view.origin, view.forward);
    float nearest = caster_is_strand(caster) ? min(start, start + dot(caster.axis, view.forward)) : start - caster.radius;
    nearest = caster_is_sheet(caster) ? start : nearest;
    items[gl_WorkGroupID.z * capacity + i] = Item(float_order(nearest), i);
}
