// The tiles and blocks that a caster may touch, even if it touches them only between texel centres.
#ifndef MAPS_DETAIL_CASTERS_GLSL
#define MAPS_DETAIL_CASTERS_GLSL
#include "maps/bins/tiles.glsl"
#include "maps/detail/blocks.glsl"

// Tiles of 8×8 texels of `view` that the caster's bounds touch: low to high, both included; false if there are none.
bool caster_touches(View view, Caster caster, out uvec2 low_tile, out uvec2 high_tile) {
    vec2 low, high;
    low_tile = high_tile = uvec2(0u);
    if (!caster_bounds(view, caster, low, high)) {
        return false;
    }
    vec2 size = vec2(view.width, view.height);
    low = (low * 0.5 + 0.5) * size;
    high = (high * 0.5 + 0.5) * size;
    if (any(lessThan(high, vec2(0.0))) || any(greaterThanEqual(low, size))) {
        return false;
    }
    low_tile = uvec2(clamp(low, vec2(0.0), size - 1.0)) / TILE_TEXELS;
    high_tile = uvec2(clamp(high, vec2(0.0), size - 1.0)) / TILE_TEXELS;
    return true;
}

// Clips the tiles low to high of a finer view to those within a tile of the map; false if none is left.
bool within_tile(uvec2 tile, uint side, inout uvec2 low, inout uvec2 high) {
    low = max(low, tile * side);
    high = min(high, tile * side + side - 1u);
    return all(lessThanEqual(low, high));
}
#endif
