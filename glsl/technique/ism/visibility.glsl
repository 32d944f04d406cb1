// Imperfect shadow map look-up: how much of virtual light `light` reaches `position`, 0 to 1. Sources: Ritschel et al. 2008; Reeves,
// Salesin and Cook 1987 (four comparisons, averaged). Twin: reference::twin::ism::look_up.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  what is known of all points (technique/ism/points.glsl)
//   binding 2  maps, ISM_STRIDE texels after one another, rows of distances as floats' bits
// flat: bindings 16, constants 32: ISM_SIZE ISM_STRIDE
#include "technique/ism/map.glsl"
#include "technique/ism/points.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityPoints { IsmPoints visibility_points; };
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityMaps { uint visibility_maps[]; };

// Texels from a map to the next.
CONSTANT(uint, ISM_STRIDE, 4096u)

// A receiver leaves its surface by as much as lies between the four texels that it is compared with, and by a share of what a point
// stands for.
const float RECEIVER_TEXELS = 1.5;
const float RECEIVER_POINTS = 0.5;

#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    Light l = visibility_lights[light];
    vec3 offset = position - l.position;
    float distance = length(offset), along = dot(offset, l.direction);
    float width = max(distance + along, 0.0) * (2.0 / float(ISM_SIZE));
    return position + normal * max(RECEIVER_TEXELS * width, RECEIVER_POINTS * visibility_points.radius);
}

float light_visibility(uint light, vec3 position) {
    Light l = visibility_lights[light];
    vec3 offset = into_axes(axes_of(l.direction), position - l.position);
    float square = dot(offset, offset);
    // Behind its plane it sends nothing, so that nothing stands in its way; what is no number is nowhere.
    if (!(offset.z > 0.0) || !(square < FARTHEST)) {
        return 1.0;
    }
    float distance = sqrt(square);
    vec2 at = (offset.xy / (distance + offset.z) * 0.5 + 0.5) * float(ISM_SIZE) - 0.5;
    vec2 low = floor(at), part = at - low;
    ivec2 last = ivec2(ISM_SIZE - 1u);
    float lit[4];
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = clamp(ivec2(low) + ivec2(i & 1, i >> 1), ivec2(0), last);
        float nearest = uintBitsToFloat(visibility_maps[light * ISM_STRIDE + uint(texel.y) * ISM_SIZE + uint(texel.x)]);
        lit[i] = distance <= nearest ? 1.0 : 0.0;
    }
    // So that four that agree are exactly 0 or 1.
    vec2 rows = vec2(lit[0] + part.x * (lit[1] - lit[0]), lit[2] + part.x * (lit[3] - lit[2]));
    return rows.x + part.y * (rows.y - rows.x);
}
