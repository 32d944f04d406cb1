// Look-up in the whole list of a texel: exact at texel centres, with a cost proportional to the length of the list. The reference method of
// Intel's 2010 demonstration.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  the first segment of each texel's list, R32_UINT, the maps stacked vertically
//   binding 4  segments, laid out as in maps/list/segments.glsl
// flat: bindings 56, constants 112: FILTER FILTER_RADIUS
#include "maps/list/segments.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3, r32ui) uniform readonly uimage2D visibility_heads;
layout(set = GOBO_SET, binding = 4, std430) readonly buffer VisibilitySegments { uvec4 visibility_segments[]; };

float texel_transmittance(LookUp l, ivec2 texel) {
    float optical_depth = 0.0;
    uint index = imageLoad(visibility_heads, stacked(l, texel)).r;
    while (index != NO_SEGMENT) {
        Segment segment = segment_of(visibility_segments[index]);
        // Compares first, so that a zero-length segment is a step and not 0/0; a point exactly at the step counts as behind it.
        float ramp = l.depth >= segment.exit ? 1.0
                     : l.depth <= segment.entry ? 0.0
                                                : (l.depth - segment.entry) / (segment.exit - segment.entry);
        optical_depth += segment.optical_depth * ramp;
        index = segment.next;
    }
    return exp(-optical_depth);
}
