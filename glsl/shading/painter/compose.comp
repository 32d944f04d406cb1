#version 460
// Composites the parts of a tile over each other and over the picture. Inputs: splits, layers. Output: colors.
#include "shading/camera_push.glsl"
#include "shading/painter/picture.glsl"
#include "shading/painter/set.glsl"

PAINTED_TOTALS
PAINTED_LAYERS
PAINTED_COLORS

// set 1: painter_splits
layout(set = 1, binding = 0, scalar) readonly buffer Splits { Part splits[]; };

layout(local_size_x = 64) in;

void main() {
    uint thread = gl_LocalInvocationIndex, listed = gl_WorkGroupID.y * PART_GROUPS + gl_WorkGroupID.x;
    if (listed >= totals.split) {
        return;
    }
    Part tile = splits[listed];
    uvec2 pixel = tile_pixel(size, tile.tile, thread);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec3 color = vec3(0.0), left = vec3(1.0);
    for (uint i = tile.count; i-- > 0u && is_seen(left);) {
        uint at = 2u * ((tile.slot + i) * TILE_PIXELS + thread);
        color += left * layers[at];
        left *= layers[at + 1u];
    }
    vec4 behind = imageLoad(colors, ivec2(pixel));
    imageStore(colors, ivec2(pixel), vec4(color + left * behind.rgb, behind.a));
}
