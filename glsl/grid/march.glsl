// Whether a voxel on a way through a grid is occupied. Needs visibility_bits, and the constant GRID_SIZE. Source: after Amanatides
// and Woo 1987; skipping what is empty on the levels above is ours. Twin: reference::twin::grid::Bits::march.
#ifndef GRID_MARCH_GLSL
#define GRID_MARCH_GLSL
#include "grid/grid.glsl"

// The 64 bits of a level's word.
uvec2 grid_bits(uint level, uvec3 word) {
    uint side = grid_side(GRID_SIZE, level);
    uint at = 2u * (grid_level_at(GRID_SIZE, level) + (word.z * side + word.y) * side + word.x);
    return uvec2(visibility_bits[at], visibility_bits[at + 1u]);
}

bool grid_is_empty(uvec2 bits) { return (bits.x | bits.y) == 0u; }

// The bit of a voxel, a brick or a block; its place in the word is that of its last two bits along each axis.
bool grid_has(uvec2 bits, uvec3 voxel) {
    uint bit = grid_bit(0u, voxel);
    return ((bit < 32u ? bits.x : bits.y) >> (bit & 31u) & 1u) == 1u;
}

// The bit of a voxel, of whose word nothing else is asked.
bool grid_has_voxel(uvec3 voxel) {
    uint bit = grid_bit(0u, voxel);
    return (visibility_bits[2u * grid_word(GRID_SIZE, 0u, voxel) + (bit >> 5)] >> (bit & 31u) & 1u) == 1u;
}

// Whether the 2 × 2 × 2 voxels of a brick are empty that a voxel is one of.
bool grid_octant_is_empty(uvec2 bits, uvec3 voxel) {
    uvec3 corner = voxel & 2u;
    return ((corner.z == 0u ? bits.x : bits.y) & (0x00330033u << (corner.x + 4u * corner.y))) == 0u;
}

// Where a way from `from` along `way` (voxels) enters the grid and leaves it, in lengths of `way`, at most from 0 to 1; the first
// number is the greater one where it passes by.
vec2 grid_clip(vec3 from, vec3 way) {
    vec3 inverse = 1.0 / mix(way, vec3(1e-20), equal(way, vec3(0.0)));
    vec3 low = -from * inverse, high = (vec3(GRID_SIZE) - from) * inverse;
    vec3 near = min(low, high), far = max(low, high);
    return vec2(max(0.0, max(near.x, max(near.y, near.z))), min(1.0, min(far.x, min(far.y, far.z))));
}

// Every voxel on the way, and no other: from each the way goes on into the one that it enters next, or out of all that is empty
// about it at once. Seen from where all of `way` is positive, so that only far sides are asked for.
bool march_exact(vec3 from, vec3 way) {
    vec2 range = grid_clip(from, way);
    if (range.x > range.y) {
        return false;
    }
    bvec3 turned = lessThan(way, vec3(0.0));
    uvec3 mirror = uvec3(mix(ivec3(0), ivec3(GRID_SIZE - 1u), turned));
    from = mix(from, vec3(GRID_SIZE) - from, turned);
    way = abs(way);
    vec3 inverse = 1.0 / max(way, vec3(1e-20));
    ivec3 last = ivec3(GRID_SIZE - 1u);
    ivec3 voxel = clamp(ivec3(from + way * range.x), ivec3(0), last);
    // The words that the way is in: bricks of a block, voxels of a brick.
    uvec3 block = uvec3(~0u), brick = uvec3(~0u);
    uvec2 bricks = uvec2(0u), voxels = uvec2(0u);
    // No way meets more: each turn ends at another plane between voxels.
    for (uint turn = 0u; turn < 3u * GRID_SIZE + 3u; ++turn) {
#ifdef LOOK_UP_STEPS
        ++look_up_steps;
#endif
        uvec3 at = uvec3(voxel) ^ mirror;
        if (at >> 4u != block) {
            block = at >> 4u;
            bricks = grid_bits(1u, block);
        }
        uint shift = 0u;
        if (grid_is_empty(bricks)) {
            shift = grid_is_empty(grid_bits(2u, at >> 6u)) ? 6u : 4u;
        } else if (!grid_has(bricks, at >> 2u)) {
            shift = 2u;
        } else {
            if (at >> 2u != brick) {
                brick = at >> 2u;
                voxels = grid_bits(0u, brick);
            }
            if (grid_has(voxels, at)) {
                return true;
            }
            shift = grid_octant_is_empty(voxels, at) ? 1u : 0u;
        }
        ivec3 low = (voxel >> int(shift)) << int(shift), high = low + (1 << int(shift));
        vec3 planes = (vec3(high) - from) * inverse;
        float nearest = min(planes.x, min(planes.y, planes.z));
        if (nearest >= range.y) {
            return false;
        }
        ivec3 next = clamp(ivec3(from + way * nearest), low, high - 1);
        voxel = mix(next, high, lessThanEqual(planes, vec3(nearest)));
        if (any(greaterThan(voxel, last))) {
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
        ivec3 voxel = clamp(ivec3(floor(from + way * at)), ivec3(0), ivec3(int(GRID_SIZE) - 1));
        if (grid_has_voxel(uvec3(voxel))) {
            return true;
        }
    }
    return false;
}
#endif
