#version 460
// The arithmetic in fragments: the thread's number is the pixel's place. Inputs: push constants. Output: a value and a processor
// for each pixel.
// variants: PROCESSORS 0 1
#include "bench/arithmetic.glsl"

layout(location = 0) out uvec2 value;

void main() {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    value = arithmetic(pixel.y * width + pixel.x);
}
