// Look-up in the whole per-texel list: exact at texel centres, as slow as the lists are long. The yardstick of Intel's
// 2010 demonstration.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  the first segment of each texel's list, R32_UINT, the maps one above the other
//   binding 4  segments, as maps/list/segments.glsl has them in memory
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
        // Compared first, so that a segment of no length is a step and not 0/0; its own depth lies behind it.
        float ramp = l.depth >= segment.exit ? 1.0
                     : l.depth <= segment.entry ? 0.0
                                                : (l.depth - segment.entry) / (segment.exit - segment.entry);
        optical_depth += segment.optical_depth * ramp;
        index = segment.next;
    }
    return exp(-optical_depth);
}
