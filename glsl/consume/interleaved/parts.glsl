// Which lights a pixel asks: they are dealt out in turn into parts, and each of 4 × 4 pixels has a part of its own. Under fewer than
// sixteen lights there are fewer parts, so that none is empty, and all have the same number of pixels. Twin:
// reference::twin::interleaved::parts.
#ifndef CONSUME_INTERLEAVED_PARTS_GLSL
#define CONSUME_INTERLEAVED_PARTS_GLSL

// A power of two.
uint part_count(uint lights) {
    return lights >= 16u ? 16u : lights > 0u ? 1u << uint(findMSB(lights)) : 1u;
}

// Where in 4 × 4 a place lies: 2 × 2 of 2 × 2, so that four parts lie about every pixel where there are as few.
uvec2 place_pixel(uint place) { return uvec2(place & 1u | place >> 1 & 2u, place >> 1 & 1u | place >> 2 & 2u); }

uint pixel_place(uvec2 pixel) {
    return pixel.x & 1u | (pixel.y & 1u) << 1 | (pixel.x & 2u) << 1 | (pixel.y & 2u) << 2;
}

// Lights of the part at a place.
uint part_lights(uint lights, uint place) {
    uint parts = part_count(lights);
    return (lights + parts - 1u - (place & parts - 1u)) / parts;
}
#endif
