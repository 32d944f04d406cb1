#version 460
// Runs the arithmetic in fragments; the thread's number is the pixel's index. Inputs: push constants. Output: a value and a multiprocessor
// per pixel.
// variants: PROCESSORS 0 1
#include "bench/arithmetic.glsl"

layout(location = 0) out uvec2 value;

void main() {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    value = arithmetic(pixel.y * width + pixel.x);
}
