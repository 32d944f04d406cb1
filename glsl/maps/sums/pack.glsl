// Packs drawn sums into the technique's words. Twin: reference::twin::texel_sums. A technique declares before inclusion: SUMS and
// store_sums, as for maps/sums/binned.glsl.
#ifndef MAPS_SUMS_PACK_GLSL
#define MAPS_SUMS_PACK_GLSL
#include "maps/scene.glsl"
#include "maps/sums/range.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: maps_drawn_sums
layout(set = 1, binding = 0, scalar) readonly buffer Ends { uint ends[]; };
// The targets of maps/sums/raster.glsl; bindings past its last target are not read.
layout(set = 1, binding = 1) uniform texture2D drawn_0;
layout(set = 1, binding = 2) uniform texture2D drawn_1;
layout(set = 1, binding = 3) uniform texture2D drawn_2;
layout(set = 1, binding = 4) uniform texture2D drawn_3;
layout(set = 1, binding = 5) uniform texture2D drawn_4;
layout(set = 1, binding = 6) uniform texture2D drawn_5;
layout(set = 1, binding = 7) uniform texture2D drawn_6;
layout(set = 1, binding = 8) uniform texture2D drawn_7;

vec4 drawn(uint target, ivec2 at) {
    switch (target) {
    case 0u:
        return texelFetch(drawn_0, at, 0);
    case 1u:
        return texelFetch(drawn_1, at, 0);
    case 2u:
        return texelFetch(drawn_2, at, 0);
    case 3u:
        return texelFetch(drawn_3, at, 0);
    case 4u:
        return texelFetch(drawn_4, at, 0);
    case 5u:
        return texelFetch(drawn_5, at, 0);
    case 6u:
        return texelFetch(drawn_6, at, 0);
    default:
        return texelFetch(drawn_7, at, 0);
    }
}

void main() {
    uvec2 size = map_size(), at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, size))) {
        return;
    }
    at.y += gl_WorkGroupID.z * size.y;
    uint texel = at.y * size.x + at.x;
    vec2 range = vec2(0.0, 1.0);
    if (SUM_RANGE != RANGE_SCENE) {
        range = range_of_words(uvec2(ends[2u * texel], ends[2u * texel + 1u]));
    }
    float sums[SUMS];
    for (uint k = 0u; k < SUMS; ++k) {
        sums[k] = drawn(k / 4u, ivec2(at))[k % 4u];
    }
    store_sums(texel, range, sums);
}
#endif
