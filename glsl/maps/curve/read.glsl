// Reads a stored curve. Must be declared before inclusion: uvec2 curve_pair(uint i), which returns pair i of the buffer.
#ifndef MAPS_CURVE_READ_GLSL
#define MAPS_CURVE_READ_GLSL
#include "maps/curve/pack.glsl"

// Depth range of the curve at pair `at`, if it is stored.
vec2 curve_range(uint at) { return PACKED && !TIGHT ? uintBitsToFloat(curve_pair(at)) : vec2(0.0); }

// Node i of the curve at pair `at`; `range`: depth range of a packed curve.
Node texel_node(uint at, uint i, vec2 range) {
    if (TIGHT) {
        uvec2 words = curve_pair(at + i / 4u);
        return unpack_node(((i & 2u) == 0u ? words.x : words.y) >> (i % 2u * 16u) & 0xFFFFu, vec2(0.0, 1.0));
    }
    if (PACKED) {
        uvec2 words = curve_pair(at + 1u + i / 2u);
        return unpack_node(i % 2u == 0u ? words.x : words.y, range);
    }
    uvec2 bits = curve_pair(at + i);
    return Node(uintBitsToFloat(bits.x), uintBitsToFloat(bits.y));
}
#endif
