// Look-up in the whole per-texel list: exact at texel centres, as slow as the lists are long. The yardstick that the
// seed's own demonstration compares with. Bindings as in avsm/visibility.glsl, with the lists for nodes.
#include "common/opaque_map.glsl"
#include "list/segments.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, r32ui) uniform readonly uimage2D visibility_heads;
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilitySegments { Segment visibility_segments[]; };
layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_opaque;

float texel_transmittance(ivec2 texel, float depth) {
    float optical_depth = 0.0;
    uint index = imageLoad(visibility_heads, texel).r;
    while (index != NO_SEGMENT) {
        Segment segment = visibility_segments[index];
        // Compared first, so that a segment of no length is a step and not 0/0.
        float ramp = depth <= segment.entry ? 0.0
                     : depth >= segment.exit ? 1.0
                                             : (depth - segment.entry) / (segment.exit - segment.entry);
        optical_depth += segment.optical_depth * ramp;
        index = segment.next;
    }
    return exp(-optical_depth);
}

float light_visibility(uint light, vec3 position) {
    View view = visibility_lights[light].volume;
    vec3 at = view_project(view, position);
    float opaque = opaque_visibility(visibility_lights[light], visibility_opaque, position);
    if (!(at.z > view.near)) {
        return opaque;  // in front of all casters
    }
    float depth = view_depth(view, at.z);
    Footprint footprint = view_footprint(view, at.xy);
    float transmittance = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = footprint.corner + ivec2(i & 1, i >> 1);
        float through = view_has(view, texel) ? texel_transmittance(texel, depth) : 1.0;
        transmittance += footprint.weights[i] * through;
    }
    return transmittance * opaque;
}
