#version 460
// Turns each texel's list of segments into a list of their ends, sorted by depth. An event is the start or the end of a segment: its entry
// field holds the depth of the event, its exit field the depth of the segment's other end. A zero-length segment is one event. Inputs:
// heads, segments, counters. Outputs: events; heads of the event lists. Twin: reference::twin::deep_shadow_map::events. Invariant: events
// with equal sort keys are identical, so neither the capture order nor the casters' order matters.
#include "technique/deep_shadow_map/maps.glsl"
#include "maps/rounds.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: list
layout(set = 1, binding = 0, r32ui) uniform uimage2D heads;
layout(set = 1, binding = 1, scalar) readonly buffer Segments { Segment segments[]; };
layout(set = 1, binding = 2, scalar) buffer Counters { uint counters[]; };
// set 2: deep_shadow_map
layout(set = 2, binding = 0, scalar) buffer Events { Segment events[]; };

#define SORTED_LIST events
#include "maps/list/sort.glsl"

void main() {
    uvec2 size = map_size(), texel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(texel, size))) {
        return;
    }
    // The maps of the group are stacked vertically.
    ivec2 at = ivec2(texel + uvec2(0u, gl_WorkGroupID.z * size.y));
    uint index = imageLoad(heads, at).r, head = NO_SEGMENT;
    while (index != NO_SEGMENT) {
        Segment segment = segments[index];
        if (segment.optical_depth > 0.0) {
            events[2u * index] = Segment(segment.entry, segment.exit, segment.optical_depth, head);
            head = 2u * index;
        }
        if (segment.optical_depth > 0.0 && segment.exit > segment.entry) {
            events[2u * index + 1u] = Segment(segment.exit, segment.entry, segment.optical_depth, head);
            head = 2u * index + 1u;
        }
        index = segment.next;
    }
    if (head != NO_SEGMENT) {
        head = sort(head);
    }
    imageStore(heads, at, uvec4(head, 0u, 0u, 0u));
    if (rounds_ran_out(head)) {
        counters[CUT_SHORT] = 1u;
    }
}
