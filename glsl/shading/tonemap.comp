#version 460
// Averages a pixel's samples in linear light, then applies a filmic curve. Inputs: the picture of all samples. Output: the picture for
// display, linear, 0 to 1. Twin: reference::truth::shown. Source of the curve: Narkowicz 2016, ACES filmic tone mapping curve.
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: picture_tonemapped
layout(set = 0, binding = 0) uniform texture2D samples;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D shown;

layout(push_constant, scalar) uniform TonemapPush {
    uvec2 grid;  // columns and rows of samples in a pixel
    uvec2 size;  // pixels
    float exposure;
};

vec3 filmic(vec3 light) {
    return clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec3 sum = vec3(0.0);
    for (uint y = 0u; y < grid.y; ++y) {
        for (uint x = 0u; x < grid.x; ++x) {
            sum += texelFetch(samples, ivec2(pixel * grid + uvec2(x, y)), 0).rgb;
        }
    }
    // Beyond 1e6 the curve's terms would overflow; the curve reaches 1 long before that.
    vec3 light = clamp(exposure * sum / float(grid.x * grid.y), 0.0, 1e6);
    imageStore(shown, ivec2(pixel), vec4(filmic(light), 1.0));
}
