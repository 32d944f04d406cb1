// Flux in integers, so that its sums are the same in any order. The unit is chosen so that the brightest texel has 2^22 to 2^23 units. A
// row of texels then adds up to at most 2^31 units, which fit into one word, and all rows to less than 2^48 units, which take two words,
// low word first. Twin: reference::twin::indirect.
#ifndef LIGHTS_INDIRECT_UNITS_GLSL
#define LIGHTS_INDIRECT_UNITS_GLSL

// Minimum biased exponent: lower ones are raised to it, so that a unit is never too small for a normal float.
const uint LEAST_EXPONENT = 27u;

// Returns the exponent in a float's bits, at least LEAST_EXPONENT.
uint flux_exponent(uint bits) { return max(bits >> 23, LEAST_EXPONENT); }

// Returns flux in units. `most`: the greatest flux of a texel, as float bits. A unit is a power of 2, so that the only rounding is to the
// nearest unit.
uint flux_units(float flux, uint most) {
    precise float units = flux * uintBitsToFloat((276u - flux_exponent(most)) << 23);
    precise float rounded = units + 0.5;
    return uint(rounded);
}

// Returns the size of a unit.
float flux_unit(uint most) { return uintBitsToFloat((flux_exponent(most) - 22u) << 23); }

uvec2 add(uvec2 a, uvec2 b) {
    uint carry;
    uint low = uaddCarry(a.x, b.x, carry);
    return uvec2(low, a.y + b.y + carry);
}

uvec2 subtract(uvec2 a, uvec2 b) {
    uint borrow;
    uint low = usubBorrow(a.x, b.x, borrow);
    return uvec2(low, a.y - b.y - borrow);
}

// Returns `share` / 65,536 of `a`, rounded down.
uvec2 part_of(uvec2 a, uint share) {
    uint high = a.y * share;
    uvec2 rest = add(uvec2((a.x >> 16) * share, 0u), uvec2((a.x & 0xffffu) * share >> 16, 0u));
    return add(uvec2(high << 16, high >> 16), rest);
}

bool is_less(uvec2 a, uvec2 b) { return a.y < b.y || (a.y == b.y && a.x < b.x); }
#endif
