#version 460
// Copies distances from the depth target that the points were drawn into to the maps. Source: none. Inputs: the target, head. Output: maps,
// with NOTHING in the coarser levels. Twin: technique::ism::raster.
#extension GL_EXT_samplerless_texture_functions : require
#include "technique/ism/atlas.glsl"
#include "technique/ism/drawn.glsl"

layout(local_size_x = 128) in;

// set 1: ism_target
layout(set = 1, binding = 0) uniform texture2D depths;

void main() {
    uint groups = (ISM_TEXELS + 127u) / 128u;
    uint light = GROUP_INDEX / groups, i = GROUP_INDEX % groups * 128u + gl_LocalInvocationIndex;
    if (light >= light_count || i >= ISM_TEXELS) {
        return;
    }
    uint bits = NOTHING;
    if (i < ISM_SIZE * ISM_SIZE) {
        uvec2 texel = map_corner(light, ISM_SIZE) + uvec2(i % ISM_SIZE, i / ISM_SIZE);
        float depth = texelFetch(depths, ivec2(texel), 0).r;
        bits = depth < 1.0 ? floatBitsToUint(drawn_distance(depth, head.radius)) : NOTHING;
    }
    maps[light * ISM_TEXELS + i] = bits;
}
