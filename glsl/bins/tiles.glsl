// Particles binned to tiles of 8×8 texels of the light's map. Twin: reference::bins.
#ifndef BINS_TILES_GLSL
#define BINS_TILES_GLSL
#include "common/light.glsl"
#include "common/particle.glsl"

const uint TILE_TEXELS = 8u;

uvec2 tile_counts(View view) {
    return (uvec2(view.width, view.height) + TILE_TEXELS - 1u) / TILE_TEXELS;
}

// The tiles that hold a texel centre within the particle's bounds: low to high, both included; false where none does.
bool particle_tiles(View view, Particle particle, out uvec2 low_tile, out uvec2 high_tile) {
    vec2 low, high;
    low_tile = high_tile = uvec2(0u);
    if (!particle_bounds(view, particle, low, high)) {
        return false;
    }
    vec2 size = vec2(view.width, view.height);
    // Texel i has its centre at i + 0.5.
    vec2 first = ceil(clamp((low * 0.5 + 0.5) * size - 0.5, vec2(0.0), size));
    vec2 last = floor(clamp((high * 0.5 + 0.5) * size - 0.5, vec2(-1.0), size - 1.0));
    if (any(greaterThan(first, last))) {
        return false;
    }
    low_tile = uvec2(first) / TILE_TEXELS;
    high_tile = uvec2(last) / TILE_TEXELS;
    return true;
}

// Squared distance, in units of the radius, from the particle's centre to the nearest texel centre's ray of the tile.
// Exact for parallel views; 0 for perspective ones, whose tiles are not rectangles across the rays.
float tile_distance(View view, Particle particle, uvec2 tile) {
    if (view.projection == VIEW_PERSPECTIVE) {
        return 0.0;
    }
    vec3 offset = particle.position - view.origin;
    vec2 scale = vec2(view.scale_x, view.scale_y), size = vec2(view.width, view.height);
    vec2 centre = vec2(dot(offset, view.right), dot(offset, view.up));
    vec2 low = ((vec2(tile * TILE_TEXELS) + 0.5) / size * 2.0 - 1.0) / scale;
    vec2 high = ((vec2(tile * TILE_TEXELS + TILE_TEXELS) - 0.5) / size * 2.0 - 1.0) / scale;
    vec2 apart = max(max(low - centre, centre - high), vec2(0.0)) / particle.radius;
    return dot(apart, apart);
}

// A tile may be left out where no ray of it meets the sphere; the margin is against rounding.
bool tile_missed(float distance_square) {
    return distance_square > 1.0001;
}

// Sorts as the depth at which the sphere begins, nearest within the tile: non-negative floats order as their bits do.
uint tile_key(View view, Particle particle, float distance_square) {
    float centre = dot(particle.position - view.origin, view.forward);
    float nearest = centre - particle.radius * sqrt(max(1.0 - distance_square, 0.0));
    return floatBitsToUint(max(view_depth(view, nearest), 0.0));
}
#endif
