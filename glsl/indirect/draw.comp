#version 460
// Draws the texels that virtual lights stand for: all flux in a row is divided into equal parts, and in each one unit is taken, at a
// place of the part that is the light's own in every frame; the unit's texel is drawn. Inputs: fluxes, starts. Output: picks.
// Twin: reference::twin::indirect::draw.
#include "indirect/drawn.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform DrawPush {
    uint light_count;
    uint block_count;
};

// In 1 / 65536 of a part: the golden section's multiples, which are spread evenly.
uint offset_of(uint light) { return light * 40503u & 0xffffu; }

// Of `total` units, the one that light number `light` takes: (light + offset) / light_count of them, rounded down. In numbers of 16
// bits, since the product has more than 64.
uvec2 unit_of(uint light, uvec2 total) {
    uint part[5] = uint[](0u, 0u, 0u, 0u, 0u);
    uint units[3] = uint[](total.x & 0xffffu, total.x >> 16, total.y);
    for (uint i = 0u; i < 3u; ++i) {
        uint offset = offset_of(light) * units[i], whole = light * units[i];
        part[i] += offset & 0xffffu;
        part[i + 1u] += (offset >> 16) + (whole & 0xffffu);
        part[i + 2u] += whole >> 16;
    }
    for (uint i = 0u; i < 4u; ++i) {
        part[i + 1u] += part[i] >> 16;
        part[i] &= 0xffffu;
    }
    uint rest = 0u;
    for (uint i = 4u; i >= 1u; --i) {
        uint here = rest << 16 | part[i];
        part[i] = here / light_count;
        rest = here % light_count;
    }
    return uvec2(part[1] | part[2] << 16, part[3]);
}

void main() {
    uint light = gl_WorkGroupID.x * 64u + gl_LocalInvocationIndex;
    if (light >= light_count) {
        return;
    }
    uvec2 total = starts[block_count];
    if (total == uvec2(0u)) {
        picks[light] = NO_TEXEL;
        return;
    }
    uvec2 unit = unit_of(light, total);
    // The last block that does not begin behind it.
    uint low = 0u, high = block_count;
    while (low + 1u < high) {
        uint middle = (low + high) / 2u;
        if (is_less(unit, starts[middle])) {
            high = middle;
        } else {
            low = middle;
        }
    }
    // No further than its block reaches.
    uint rest = unit.x - starts[low].x, texel = low * BLOCK;
    for (uint i = 0u; i < BLOCK; ++i) {
        uint here = flux_units(fluxes[texel], greatest);
        if (rest < here) {
            break;
        }
        rest -= here;
        ++texel;
    }
    picks[light] = texel;
}
