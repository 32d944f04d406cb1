// Selects the lights that a pixel queries. Lights are dealt out round-robin into parts, one part per pixel of a square of 4 × 4. With fewer
// than sixteen lights there are fewer parts, so that no part is empty and each part has the same number of pixels. Twin:
// reference::twin::interleaved::parts.
#ifndef CONSUME_INTERLEAVED_PARTS_GLSL
#define CONSUME_INTERLEAVED_PARTS_GLSL

// Number of parts, a power of two.
uint part_count(uint lights) {
    return lights >= 16u ? 16u : lights > 0u ? 1u << uint(findMSB(lights)) : 1u;
}

// The pixel at a place in the square of 4 × 4. The place's bits alternate between x and y, so that with only four parts every 2 × 2 pixels
// have all four.
uvec2 place_pixel(uint place) { return uvec2(place & 1u | place >> 1 & 2u, place >> 1 & 1u | place >> 2 & 2u); }

uint pixel_place(uvec2 pixel) {
    return pixel.x & 1u | (pixel.y & 1u) << 1 | (pixel.x & 2u) << 1 | (pixel.y & 2u) << 2;
}

// Number of lights in the part at a place.
uint part_lights(uint lights, uint place) {
    uint parts = part_count(lights);
    return (lights + parts - 1u - (place & parts - 1u)) / parts;
}
#endif
