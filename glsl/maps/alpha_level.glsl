// The level of a texture for a map whose texels are larger than the texture's, and what blocks light there. Behind the first texels of a
// texture are, per level from 1 on, the word of its texels and its threshold, and then these texels: see scene::model::alpha_levels. A
// triangle whose factors are not all 1 stays at level 0. Needs ALPHA_TRIANGLES. Twin: reference::twin::alpha.
#ifndef MAPS_ALPHA_LEVEL_GLSL
#define MAPS_ALPHA_LEVEL_GLSL
#include "world/alpha.glsl"
#include "world/view.glsl"

// 0: alpha at level 0 is compared with the cutoff. 1: the share that blocks light, at the level, with its threshold. 2: with a random
// number.
CONSTANT(uint, ALPHA_TEST, 0u)
const uint ALPHA_TEST_HASH = 2u;

// Levels end at 8 texels across or down. Twin: SMALLEST in scene::model::alpha_levels.
const int ALPHA_LAST_LEVEL = 3;

// A cutoff that stands for random numbers.
const float ALPHA_HASHED = -1.0;

// Place of a corner in a map, in texels from its centre.
vec2 alpha_corner_texel(View view, vec3 corner) {
    precise vec3 offset = corner - view.origin;
    precise vec2 across = vec2((offset.x * view.right.x + offset.y * view.right.y + offset.z * view.right.z) * view.scale_x,
                               (offset.x * view.up.x + offset.y * view.up.y + offset.z * view.up.z) * view.scale_y);
    precise float z = offset.x * view.forward.x + offset.y * view.forward.y + offset.z * view.forward.z;
    precise vec2 place = across * (0.5 * vec2(view.width, view.height));
    if (view.projection != VIEW_PARALLEL) {
        // In front of the map a triangle counts as large.
        precise vec2 divided = place * alpha_reciprocal(max(z, view.near));
        place = divided;
    }
    return place;
}

// The level at which a triangle's texture has about as many texels as the map.
uint alpha_level(View view, vec3 corners[3], Alpha alpha) {
    bool is_plain = alpha.factors[0] == 1.0 && alpha.factors[1] == 1.0 && alpha.factors[2] == 1.0;
    if (ALPHA_TEST == 0u || alpha.texels == 0u || alpha.cutoff == ALPHA_SEE_THROUGH || !is_plain) {
        return 0u;
    }
    uvec2 size = uvec2(alpha.size & 0x3fffu, alpha.size >> 14u & 0x3fffu) + 1u;
    vec2 a = alpha_corner_texel(view, corners[0]), b = alpha_corner_texel(view, corners[1]), c = alpha_corner_texel(view, corners[2]);
    precise vec2 ab = b - a, ac = c - a, u = alpha.uvs[1] - alpha.uvs[0], v = alpha.uvs[2] - alpha.uvs[0];
    precise float in_map = abs(ab.x * ac.y - ab.y * ac.x), in_texture = abs(u.x * v.y - u.y * v.x);
    precise float texels = in_texture * (float(size.x) * float(size.y)), most_texels = 2.0 * in_map;
    uint level = 0u, most = uint(max(findMSB(max(size.x, size.y)) - ALPHA_LAST_LEVEL, 0));
    while (texels > most_texels && level < most) {
        texels *= 0.25;
        ++level;
    }
    return level;
}

// Alpha with the texels, the size and the threshold of a level.
Alpha alpha_at_level(Alpha alpha, uint level) {
    if (ALPHA_TEST == 0u || level == 0u) {
        return alpha;
    }
    uvec2 size = uvec2(alpha.size & 0x3fffu, alpha.size >> 14u & 0x3fffu) + 1u;
    uint head = alpha.texels + (size.x * size.y + 3u) / 4u + 2u * (level - 1u);
    alpha.texels = alpha_word(head);
    alpha.cutoff = ALPHA_TEST == ALPHA_TEST_HASH ? ALPHA_HASHED : uintBitsToFloat(alpha_word(head + 1u));
    size = max(size >> level, uvec2(1u)) - 1u;
    alpha.size = alpha.size & 0xF0000000u | size.y << 14u | size.x;
    return alpha;
}

uint alpha_hash(uint bits) {
    uint state = bits * 747796405u + 2891336453u;
    uint word = (state >> ((state >> 28) + 4u) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

// Whether a point of triangle `number` blocks light. `at`: see alpha_value. Random numbers stay with the surface: they depend on the
// triangle, and on the place in the texture to half a texel of the level. Sources: Wyman and McGuire 2017; O'Neill 2014 (PCG), Jarzynski
// and Olano 2020 (the hash).
bool alpha_stands(Alpha alpha, uint number, vec2 at) {
    float cutoff = alpha.cutoff;
    if (ALPHA_TEST == ALPHA_TEST_HASH && cutoff == ALPHA_HASHED) {
        vec2 twice = 2.0 * (vec2(uvec2(alpha.size & 0x3fffu, alpha.size >> 14u & 0x3fffu)) + 1.0);
        precise vec2 uv = alpha.uvs[0] + at.x * (alpha.uvs[1] - alpha.uvs[0]) + at.y * (alpha.uvs[2] - alpha.uvs[0]);
        precise vec2 place = uv * twice;
        ivec2 cell = ivec2(floor(clamp(place, vec2(-1e9), vec2(1e9))));
        uint bits = alpha_hash(number ^ alpha_hash(uint(cell.x) ^ alpha_hash(uint(cell.y))));
        precise float share = (float(bits >> 9) + 0.5) * (1.0 / 8388608.0);
        cutoff = share;
    }
    return alpha_value(alpha, at) >= cutoff;
}
#endif
