#version 460
// Composites layers over a pixel in drawing order, with fragment shader interlock. Inputs: the layer, push constants. Input and output:
// layered.
#extension GL_ARB_fragment_shader_interlock : require
#include "bench/layers.glsl"

layout(pixel_interlock_ordered) in;
layout(location = 0) flat in uint layer;

// set 0: layered
layout(set = 0, binding = 0, rgba32f) uniform coherent image2D layered;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 color = layer_color(layer);
    beginInvocationInterlockARB();
    imageStore(layered, pixel, over(imageLoad(layered, pixel), color));
    endInvocationInterlockARB();
}
