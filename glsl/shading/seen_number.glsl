// The number of the triangle that each pixel sees, counted from 1; 0 is the sky. Needs, declared before: a texture `numbers`, which the
// rasterizer draws, and a buffer `seen`, which compute passes fill: the number counted from 0, 0xFFFFFFFF for the sky, then z.
#ifndef CONSUME_SEEN_NUMBER_GLSL
#define CONSUME_SEEN_NUMBER_GLSL

// Whether compute passes have found it.
CONSTANT(bool, SEEN_BY_COMPUTE, false)

uint seen_number(ivec2 pixel, uint width) {
    return SEEN_BY_COMPUTE ? seen[2u * (uint(pixel.y) * width + uint(pixel.x))] + 1u : texelFetch(numbers, pixel, 0).r;
}
#endif
