// Texels of all reflective shadow maps in one row: map after map, each along Morton's curve, so that what stands side by side in
// the row lies side by side in the map. Twin: reference::twin::indirect::{place, map_of}.
#ifndef INDIRECT_TEXELS_GLSL
#define INDIRECT_TEXELS_GLSL

// Texels a side of a map, as a power of 2.
CONSTANT(uint, SIDE_BITS, 8u)

uint texel_map(uint texel) { return texel >> (2u * SIDE_BITS); }

// Every other bit, from the lowest.
uint morton_axis(uint bits) {
    bits &= 0x55555555u;
    bits = (bits | bits >> 1) & 0x33333333u;
    bits = (bits | bits >> 2) & 0x0f0f0f0fu;
    bits = (bits | bits >> 4) & 0x00ff00ffu;
    return (bits | bits >> 8) & 0xffffu;
}

uvec2 texel_place(uint texel) {
    uint at = texel & ((1u << (2u * SIDE_BITS)) - 1u);
    return uvec2(morton_axis(at), morton_axis(at >> 1));
}
#endif
