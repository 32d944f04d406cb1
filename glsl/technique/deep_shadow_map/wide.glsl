// 64-bit integers as two words, low word first. Negative numbers are in two's complement, so that addition needs no special case for them.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_WIDE_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_WIDE_GLSL

uvec2 wide_plus(uvec2 a, uvec2 b) {
    uint low = a.x + b.x;
    return uvec2(low, a.y + b.y + uint(low < a.x));
}

uvec2 wide_minus(uvec2 a, uvec2 b) { return uvec2(a.x - b.x, a.y - b.y - uint(a.x < b.x)); }

uvec2 wide_times(uvec2 a, uint b) {
    uint high, low;
    umulExtended(a.x, b, high, low);
    return uvec2(low, a.y * b + high);
}

// Converts a number from 0 to below 2^63, rounding down.
uvec2 wide_of(float number) {
    uint high = uint(number * (1.0 / 4294967296.0));
    return uvec2(uint(number - float(high) * 4294967296.0), high);
}

float wide_float(uvec2 number) { return float(number.y) * 4294967296.0 + float(number.x); }
#endif
