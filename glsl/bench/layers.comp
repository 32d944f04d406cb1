#version 460
// Composites layers over a pixel in order, one thread per pixel. Inputs: push constants. Input and output: layered.
#include "bench/layers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: layered
layout(set = 0, binding = 0, rgba32f) uniform image2D layered;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec4 color = imageLoad(layered, pixel);
    for (uint layer = 0u; layer < layers; ++layer) {
        color = over(color, layer_color(layer));
    }
    imageStore(layered, pixel, color);
}
