// Whether a triangle with alpha may block light in a voxel, or mask cell: false if it is see-through, or if only holes of it are there. The
// place in the texture is linear in the position, so the voxel has a range of places, and each texel in that range is looked at. Source:
// ours. Twin: reference::twin::alpha::covers.
#ifndef WORLD_ALPHA_COVER_GLSL
#define WORLD_ALPHA_COVER_GLSL
#define EXACT
#define ALPHA_TRIANGLES triangles
#include "world/alpha.glsl"

// Maximum number of texels to look at; beyond it, the triangle counts as blocking. Twin: MOST_TEXELS in reference::truth::alpha.
const int MOST_TEXELS = 256;
// Margin in texels for rounding.
const float TEXEL_MARGIN = 1.0 / 1024.0;

// The texel that a place beyond the texture's border shows.
int wrapped(int at, int size, uint wrap) {
    if (wrap == ALPHA_CLAMP) {
        return clamp(at, 0, size - 1);
    }
    int period = wrap == ALPHA_MIRROR ? 2 * size : size;
    // A remainder that is never negative.
    at = at >= 0 ? at % period : period - 1 - (-at - 1) % period;
    return at < size ? at : period - 1 - at;
}

// Greatest alpha of the texels of a range of places.
float most_texel(Alpha alpha, vec2 low, vec2 high) {
    ivec2 size = ivec2(alpha.size & 0x3fffu, alpha.size >> 14u & 0x3fffu) + 1;
    precise vec2 from = low * vec2(size) - (0.5 + TEXEL_MARGIN), to = high * vec2(size) - (0.5 - TEXEL_MARGIN);
    // Far from 0 the numbers would not fit, and so many texels are not looked at.
    if (any(greaterThan(to - from, vec2(MOST_TEXELS))) || any(greaterThan(abs(from), vec2(1e6)))) {
        return 1.0;
    }
    ivec2 first = ivec2(floor(from)), count = ivec2(floor(to)) + 2 - first;
    if (count.x * count.y > MOST_TEXELS) {
        return 1.0;
    }
    float most = 0.0;
    for (int i = 0; i < count.x * count.y; ++i) {
        int x = wrapped(first.x + i % count.x, size.x, alpha.size >> 28u & 3u);
        int y = wrapped(first.y + i / count.x, size.y, alpha.size >> 30u);
        most = max(most, alpha_texels(alpha, size.x, ivec2(x), y).x);
    }
    return most * (1.0 / 255.0);
}

// `low`: the voxel's lowest corner, `side`: its side, both in the unit of the triangle's `corners`.
bool alpha_covers(uint triangle, vec3 corners[3], vec3 low, float side) {
    uint number = alpha_number(triangle);
    if (number == 0u) {
        return true;
    }
    Alpha alpha = alpha_record(number);
    if (alpha.cutoff == ALPHA_SEE_THROUGH) {
        return false;
    }
    float most = max(alpha.factors[0], max(alpha.factors[1], alpha.factors[2]));
    if (alpha.texels != 0u) {
        precise vec3 middle = low + 0.5 * side;
        precise vec2 across = alpha.uvs[1] - alpha.uvs[0], down = alpha.uvs[2] - alpha.uvs[0];
        AlphaPlane plane = alpha_plane(corners);
        vec2 at = alpha_weights(plane, middle);
        precise vec2 uv = alpha.uvs[0] + at.x * across + at.y * down;
        // How far the place is from `uv` anywhere in the voxel.
        precise vec2 reach = vec2(0.0);
        for (uint axis = 0u; axis < 3u; ++axis) {
            precise vec2 by = side * vec2(plane.second[axis], plane.third[axis]);
            reach += 0.5 * abs(by.x * across + by.y * down);
        }
        vec2 least_uv = min(alpha.uvs[0], min(alpha.uvs[1], alpha.uvs[2]));
        vec2 most_uv = max(alpha.uvs[0], max(alpha.uvs[1], alpha.uvs[2]));
        precise vec2 from = max(uv - reach, least_uv), to = min(uv + reach, most_uv);
        most *= most_texel(alpha, min(from, to), max(from, to));
    }
    return most >= alpha.cutoff * (1.0 - 1e-5);
}
#endif
