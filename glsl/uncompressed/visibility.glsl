// Look-up in the whole per-texel list: exact at texel centres, as slow as the lists are long. The yardstick that the
// seed's own demonstration compares with. Bindings: lights, heads (the maps one above the other), segments, the opaque
// map, maps. Specialization constants 0 and 1: those of common/filter.glsl.
#define FILTER_CONSTANT 0
#include "common/filter.glsl"
#include "common/opaque_map.glsl"
#include "list/segments.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, r32ui) uniform readonly uimage2D visibility_heads;
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilitySegments { Segment visibility_segments[]; };
layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_opaque;
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityMaps { Map visibility_maps[]; };

float texel_transmittance(ivec2 texel, float depth) {
    float optical_depth = 0.0;
    uint index = imageLoad(visibility_heads, texel).r;
    while (index != NO_SEGMENT) {
        Segment segment = visibility_segments[index];
        // Compared first, so that a segment of no length is a step and not 0/0; its own depth lies behind it.
        float ramp = depth >= segment.exit ? 1.0
                     : depth <= segment.entry ? 0.0
                                              : (depth - segment.entry) / (segment.exit - segment.entry);
        optical_depth += segment.optical_depth * ramp;
        index = segment.next;
    }
    return exp(-optical_depth);
}

float light_visibility(uint light, vec3 position) {
    uint map = light_map(visibility_lights[light], position);
    View view = visibility_maps[map].volume, opaque_view = visibility_maps[map].opaque;
    float opaque = opaque_visibility(visibility_lights[light], opaque_view, map, visibility_opaque, position);
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return opaque;  // in front of all casters
    }
    float depth = view_depth(view, at.z);
    Filter f = filter_at(view, at.xy);
    ivec2 row = ivec2(0, map * view.height);
    float transmittance = 0.0;
    for (int i = 0; i < filter_side() * filter_side(); ++i) {
        ivec2 texel = filter_texel(f, i);
        float through = view_has(view, texel) ? texel_transmittance(texel + row, depth) : 1.0;
        transmittance += filter_weight(f, i) * through;
    }
    return transmittance * opaque;
}
