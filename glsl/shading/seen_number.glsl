// The number of the triangle that each pixel sees, counted from 1; 0 is the sky. Must be declared before inclusion: a texture `numbers`,
// drawn by the rasterizer, and a buffer `seen`, filled by compute passes: the number counted from 0, 0xFFFFFFFF for the sky, then z.
#ifndef CONSUME_SEEN_NUMBER_GLSL
#define CONSUME_SEEN_NUMBER_GLSL

// Whether compute passes found the triangle.
CONSTANT(bool, SEEN_BY_COMPUTE, false)

uint seen_number(ivec2 pixel, uint width) {
    return SEEN_BY_COMPUTE ? seen[2u * (uint(pixel.y) * width + uint(pixel.x))] + 1u : texelFetch(numbers, pixel, 0).r;
}
#endif
