// Whether a voxel on a way through a grid is occupied. Needs visibility_grid and visibility_bits. Source: after Amanatides and Woo
// 1987; skipping what is empty on the levels above is ours. Twin: reference::twin::grid::Bits::march.
#ifndef GRID_MARCH_GLSL
#define GRID_MARCH_GLSL
#include "grid/grid.glsl"

bool grid_has(uint level, uvec3 voxel) {
    uint bit = grid_bit(level, voxel);
    uint word = 2u * grid_word(visibility_grid.size, level, voxel) + (bit >> 5);
    return (visibility_bits[word] >> (bit & 31u) & 1u) == 1u;
}

// Where a way from `from` along `way` (voxels) enters the grid and leaves it, in lengths of `way`, at most from 0 to 1; the first
// number is the greater one where it passes by.
vec2 grid_clip(vec3 from, vec3 way) {
    vec3 inverse = 1.0 / mix(way, vec3(1e-20), equal(way, vec3(0.0)));
    vec3 low = -from * inverse, high = (vec3(visibility_grid.size) - from) * inverse;
    vec3 near = min(low, high), far = max(low, high);
    return vec2(max(0.0, max(near.x, max(near.y, near.z))), min(1.0, min(far.x, min(far.y, far.z))));
}

// Every voxel on the way, and no other: from each the way goes on into the one that it enters next, or out of all that is empty
// about it at once.
bool march_exact(vec3 from, vec3 way) {
    vec2 range = grid_clip(from, way);
    if (range.x > range.y) {
        return false;
    }
    vec3 inverse = 1.0 / mix(way, vec3(1e-20), equal(way, vec3(0.0)));
    ivec3 last = ivec3(int(visibility_grid.size) - 1);
    ivec3 voxel = clamp(ivec3(floor(from + way * range.x)), ivec3(0), last);
    // No way meets more: each turn ends at another plane between voxels.
    for (uint turn = 0u; turn < 3u * visibility_grid.size + 3u; ++turn) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        uint shift = !grid_has(2u, uvec3(voxel)) ? 4u : !grid_has(1u, uvec3(voxel)) ? 2u : 0u;
        if (shift == 0u && grid_has(0u, uvec3(voxel))) {
            return true;
        }
        ivec3 low = (voxel >> int(shift)) << int(shift), high = low + (1 << int(shift));
        vec3 planes = mix(vec3(low), vec3(high), greaterThan(way, vec3(0.0)));
        vec3 at = mix((planes - from) * inverse, vec3(FARTHEST), equal(way, vec3(0.0)));
        uint axis = at.x <= at.y && at.x <= at.z ? 0u : at.y <= at.z ? 1u : 2u;
        if (at[axis] >= range.y) {
            return false;
        }
        voxel = clamp(ivec3(floor(from + way * at[axis])), low, high - 1);
        voxel[axis] = way[axis] > 0.0 ? high[axis] : low[axis] - 1;
        if (voxel[axis] < 0 || voxel[axis] > last[axis]) {
            return false;
        }
    }
    return false;
}

// Even steps: what lies between two of them is not seen.
bool march_steps(vec3 from, vec3 way, uint steps, float offset) {
    vec2 range = grid_clip(from, way);
    for (uint i = 0u; i < steps && range.x <= range.y; ++i) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        float at = mix(range.x, range.y, (float(i) + offset) / float(steps));
        ivec3 voxel = clamp(ivec3(floor(from + way * at)), ivec3(0), ivec3(int(visibility_grid.size) - 1));
        if (grid_has(0u, uvec3(voxel))) {
            return true;
        }
    }
    return false;
}
#endif
