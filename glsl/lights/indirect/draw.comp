#version 460
// Chooses the texels that become virtual lights, by flux. Each map gets lights in proportion to its share of the flux. Each light of a map
// has a fixed position in a square, the same in every frame. The square is warped onto the map so that equal areas of the square have equal
// flux: one axis covers the map's rows, the other the texels of the chosen row. A small motion therefore moves the chosen rows and texels
// only a little. Inputs: fluxes, sums, starts. Output: picks. Twin: reference::twin::indirect::draw.
#include "lights/indirect/drawn.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform DrawPush {
    uint light_count;
    uint map_count;
};

// Returns a light's position in the square, in 1 / 65536 of its sides. Roberts' sequence R2 spreads consecutive lights evenly.
uvec2 place_of(uint light) { return uvec2(light * 3242174889u, light * 2447445413u) >> 16; }

// Divides `total` units into light_count equal parts, and returns the unit in the middle of part `light`: total · (light + 1/2) /
// light_count, rounded down. Computed in 16-bit digits, since the product may have more than 64 bits.
uvec2 unit_of(uint light, uvec2 total) {
    uint part[4] = uint[](total.x & 0xffffu, total.x >> 16, total.y, 0u);
    uint carry = 0u, rest = 0u;
    for (uint i = 0u; i < 4u; ++i) {
        uint here = part[i] * (2u * light + 1u) + carry;
        part[i] = here & 0xffffu;
        carry = here >> 16;
    }
    for (uint i = 4u; i-- > 0u;) {
        uint here = rest << 16 | part[i];
        part[i] = here / (2u * light_count);
        rest = here % (2u * light_count);
    }
    return uvec2(part[0] | part[1] << 16, part[2] | part[3] << 16);
}

// Returns the last of `count` steps that begins at or before the unit. Steps have 2^step_bits rows each, from `first` on.
uint step_of(uvec2 unit, uint first, uint count, uint step_bits) {
    uint low = 0u, high = count;
    while (low + 1u < high) {
        uint middle = (low + high) / 2u;
        if (is_less(unit, starts[first + (middle << step_bits)])) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

void main() {
    uint light = gl_WorkGroupID.x * 64u + gl_LocalInvocationIndex;
    if (light >= light_count) {
        return;
    }
    uvec2 total = starts[map_count << SIDE_BITS];
    if (total == uvec2(0u)) {
        picks[light] = NO_TEXEL;
        return;
    }
    uvec2 place = place_of(light);
    uint first = step_of(unit_of(light, total), 0u, map_count, SIDE_BITS) << SIDE_BITS;
    uvec2 before = starts[first], here = subtract(starts[first + SIDE], before);
    uint row = first + step_of(add(before, part_of(here, place.y)), first, SIDE, 0u);
    uint rest = part_of(uvec2(sums[row], 0u), place.x).x, texel = row << SIDE_BITS;
    for (uint i = 0u; i < SIDE; ++i) {
        uint units = flux_units(fluxes[texel], greatest);
        if (rest < units) {
            break;
        }
        rest -= units;
        ++texel;
    }
    picks[light] = texel;
}
