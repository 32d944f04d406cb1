#version 460
// Computes which pixels each caster may cover, and the number of tiles that the casters of a workgroup reach. Clears the ranges of all
// tiles. Inputs: camera, casters, order. Outputs: boxes, sums, ranges. Twin: reference::twin::painter.
#include "shading/painter/list_set.glsl"

layout(local_size_x = LIST_THREADS) in;

LIST_CASTERS
LIST_ORDER
LIST_BOXES
LIST_SUMS
LIST_RANGES
LIST_CAMERA

shared uint sum;

// The pixels whose centres are within a caster's bounds.
uvec2 pixels_of(Caster caster) {
    vec2 low, high, pixels = vec2(size);
    if (!caster_bounds(camera, caster, low, high)) {
        return NO_PIXELS;
    }
    vec2 first = ceil(clamp((low * 0.5 + 0.5) * pixels - 0.5, vec2(0.0), pixels));
    vec2 last = floor(clamp((high * 0.5 + 0.5) * pixels - 0.5, vec2(-1.0), pixels - 1.0));
    if (any(greaterThan(first, last))) {
        return NO_PIXELS;
    }
    uvec2 low_pixel = uvec2(first), high_pixel = uvec2(last);
    return uvec2(low_pixel.x | low_pixel.y << 16u, high_pixel.x | high_pixel.y << 16u);
}

void main() {
    uint thread = gl_LocalInvocationIndex, i = list_group() * LIST_THREADS + thread;
    uvec2 tiles = tile_counts();
    for (uint tile = i; tile < tiles.x * tiles.y; tile += gl_NumWorkGroups.x * gl_NumWorkGroups.y * LIST_THREADS) {
        ranges[tile] = uvec2(0u);
    }
    if (thread == 0u) {
        sum = 0u;
    }
    barrier();
    if (i < count) {
        uint caster = order[first + i];
        uvec2 box = pixels_of(casters[caster]);
        boxes[caster] = box;
        uvec2 tile, reached;
        tiles_of(box, tile, reached);
        atomicAdd(sum, reached.x * reached.y);
    }
    barrier();
    if (thread == 0u && list_group() * LIST_THREADS < count) {
        sums[list_group()] = sum;
    }
}
