// Transmittance along a segment through the grid. The extinction at a point is interpolated linearly between the centres of the surrounding
// voxels. It is sampled at equidistant steps, or at random points (ratio tracking), which is unbiased. Needs the same declarations as
// grid/march_media.glsl. Sources: Novák et al. 2014 (ratio tracking); O'Neill 2014 (PCG), Jarzynski and Olano 2020 (the hash). Twin:
// reference::twin::soft.
#ifndef GRID_SOFT_GLSL
#define GRID_SOFT_GLSL
#include "grid/march_media.glsl"

// Optical depth of a path of one voxel's length.
float media_soft(vec3 place) {
    vec3 at = clamp(place - 0.5, vec3(0.0), vec3(GRID_SIZE - 1u));
    uvec3 corner = min(uvec3(at), uvec3(GRID_SIZE - 2u));
    vec3 share = at - vec3(corner);
    float sum = 0.0;
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 high = uvec3(i & 1u, i >> 1 & 1u, i >> 2), voxel = corner + high;
        vec3 weights = mix(1.0 - share, share, equal(high, uvec3(1u)));
        if (grid_has(media_bits(1u, voxel >> 4u), voxel >> 2u)) {
            sum += weights.x * weights.y * weights.z * media_of(voxel, media_bits(0u, voxel >> 2u));
        }
    }
    return sum;
}

// Takes one sample per step; the steps are equal parts of the segment.
float media_soft_steps(vec3 from, vec3 way, uint steps, float offset) {
    vec2 range = grid_clip(from, way, GRID_SIZE);
    float each = (range.y - range.x) * length(way) / float(steps), sum = 0.0;
    for (uint i = 0u; i < steps && range.x <= range.y; ++i) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        sum += media_soft(from + way * mix(range.x, range.y, (float(i) + offset) / float(steps))) * each;
    }
    return min(sum, MEDIA_DARK);
}

// Largest optical depth per voxel that ratio tracking can represent: it leaves e⁻⁸ of the light.
const float RATIO_MOST = 8.0;

uint ratio_hash(uint bits) {
    uint state = bits * 747796405u + 2891336453u;
    uint word = (state >> ((state >> 28) + 4u) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

// Random estimate of a segment's transmittance: its mean over many seeds is exp(−optical depth). No voxel's optical depth exceeds `most`.
float media_ratio(vec3 from, vec3 way, float most, uint seed) {
    vec2 range = grid_clip(from, way, GRID_SIZE);
    float per_voxel = 1.0 / length(way), majorant = min(most, RATIO_MOST), left = 1.0, at = range.x;
    // Bounds the loop. A segment through the grid is at most √3 · GRID_SIZE voxels long. On average it takes at most RATIO_MOST = 8 random
    // steps per voxel of its length: 14 · GRID_SIZE steps in all. 64 · GRID_SIZE leaves a margin for chance.
    for (uint i = 0u; i < 64u * GRID_SIZE && majorant > 0.0 && left > 0.0; ++i) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        seed = ratio_hash(seed + i);
        at -= log((float(seed >> 9) + 0.5) / 8388608.0) * per_voxel / majorant;
        if (!(at < range.y)) {
            break;
        }
        left *= 1.0 - min(media_soft(from + way * at), majorant) / majorant;
    }
    return left;
}
#endif
