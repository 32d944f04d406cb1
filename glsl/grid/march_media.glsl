// How much light smoke and hair absorb along a segment through a grid: in every voxel on it (media_exact), or in voxels at equidistant
// steps (media_steps). Needs visibility_media, visibility_media_bits, the constant GRID_SIZE, and `media_towards`: a voxel's extinction in
// the segment's direction, from its mean extinction. If MEDIA_VISIT is defined, `media_visit` is called for each stretch of a segment in
// turn. Its arguments are the stretch's extinction times the segment's length, and the positions on the segment, 0 to 1, at which the
// stretch begins and ends. Source: after Amanatides and Woo 1987; skipping empty space on the levels above is ours.
// Twin: reference::twin::media::Media, march_exact and march_steps.
#ifndef GRID_MARCH_MEDIA_GLSL
#define GRID_MARCH_MEDIA_GLSL
#include "grid/media.glsl"
#include "grid/walk.glsl"

// Optical depth beyond which no light is left.
const float MEDIA_DARK = 80.0;

uvec2 media_bits(uint level, uvec3 word) {
    uint side = grid_side(GRID_SIZE, level);
    uint at = 2u * (grid_level_at(GRID_SIZE, level) + (word.z * side + word.y) * side + word.x);
    return uvec2(visibility_media_bits[at], visibility_media_bits[at + 1u]);
}

// Optical depth of a path of one voxel's length through a voxel; `full` is its brick's word of level 0.
float media_of(uvec3 voxel, uvec2 full) {
    float sum = float(visibility_media[media_at(GRID_SIZE, voxel)]) * (1.0 / MEDIA_UNITS);
    return grid_has(full, voxel) ? MEDIA_FULL : media_towards(sum, voxel);
}

// Sums every voxel on the segment, weighted by the segment's length inside it, and skips empty space in one step. Stops when no light is
// left.
float media_exact(vec3 from, vec3 way) {
    March march;
    ivec3 voxel;
    if (!march_begin(from, way, GRID_SIZE, march, voxel)) {
        return 0.0;
    }
    uvec3 block = uvec3(~0u), brick = uvec3(~0u);
    uvec2 bricks = uvec2(0u), full = uvec2(0u);
    float begin = march.range.x, voxels = length(march.way), sum = 0.0;
    for (uint turn = 0u; turn < 3u * GRID_SIZE + 3u; ++turn) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        uvec3 at = uvec3(voxel) ^ march.mirror;
        if (at >> 4u != block) {
            block = at >> 4u;
            bricks = media_bits(1u, block);
        }
        uint shift = 0u;
        float each = 0.0;
        if (grid_is_empty(bricks)) {
            shift = grid_is_empty(media_bits(2u, at >> 6u)) ? 6u : 4u;
        } else if (!grid_has(bricks, at >> 2u)) {
            shift = 2u;
        } else {
            if (at >> 2u != brick) {
                brick = at >> 2u;
                full = media_bits(0u, brick);
            }
            each = media_of(at, full);
        }
        vec3 planes = march_planes(march, voxel, shift);
        float nearest = min(planes.x, min(planes.y, planes.z)), end = clamp(nearest, begin, march.range.y);
        sum += each * ((end - begin) * voxels);
#ifdef MEDIA_VISIT
        media_visit(each * voxels, begin, end);
#endif
        if (nearest >= march.range.y || sum >= MEDIA_DARK) {
            break;
        }
        begin = end;
        if (!march_on(march, planes, nearest, shift, voxel)) {
            break;
        }
    }
    return min(sum, MEDIA_DARK);
}

// Takes one sample per step; the steps are equal parts of the segment.
float media_steps(vec3 from, vec3 way, uint steps, float offset) {
    vec2 range = grid_clip(from, way, GRID_SIZE);
    float each = (range.y - range.x) * length(way) / float(steps), sum = 0.0;
    for (uint i = 0u; i < steps && range.x <= range.y; ++i) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        float at = mix(range.x, range.y, (float(i) + offset) / float(steps));
        uvec3 voxel = uvec3(clamp(ivec3(floor(from + way * at)), ivec3(0), ivec3(int(GRID_SIZE) - 1)));
        if (grid_has(media_bits(1u, voxel >> 4u), voxel >> 2u)) {
            sum += media_of(voxel, media_bits(0u, voxel >> 2u)) * each;
        }
    }
    return min(sum, MEDIA_DARK);
}
#endif
