// Follows a way through a grid from voxel to voxel, and leaves empty space in one step. Source: after Amanatides and Woo 1987; skipping
// empty space on the levels above is ours. Twin: reference::twin::grid::Bits.
#ifndef GRID_WALK_GLSL
#define GRID_WALK_GLSL
#include "grid/grid.glsl"

bool grid_is_empty(uvec2 bits) { return (bits.x | bits.y) == 0u; }

// The bit of a voxel, brick or block in a word of 64; the last two bits of its place along each axis say which.
bool grid_has(uvec2 bits, uvec3 voxel) {
    uint bit = grid_bit(0u, voxel);
    return ((bit < 32u ? bits.x : bits.y) >> (bit & 31u) & 1u) == 1u;
}

// Whether a voxel's octant of its brick, 2 × 2 × 2 voxels, is empty; likewise of bricks in a block, and of blocks.
bool grid_octant_is_empty(uvec2 bits, uvec3 voxel) {
    uvec3 corner = voxel & 2u;
    return ((corner.z == 0u ? bits.x : bits.y) & (0x00330033u << (corner.x + 4u * corner.y))) == 0u;
}

// Where a way from `from` along `way` enters a box and leaves it, in lengths of `way`, at most from 0 to 1. Where the way misses
// the box, the first number is greater than the second.
vec2 box_clip(vec3 from, vec3 way, vec3 first, vec3 last) {
    vec3 inverse = 1.0 / mix(way, vec3(1e-20), equal(way, vec3(0.0)));
    vec3 low = (first - from) * inverse, high = (last - from) * inverse;
    vec3 near = min(low, high), far = max(low, high);
    return vec2(max(0.0, max(near.x, max(near.y, near.z))), min(1.0, min(far.x, min(far.y, far.z))));
}

// Where a way from `from` along `way` enters a grid of so many voxels per side and leaves it, in lengths of `way`, at most from 0 to 1.
// Where the way misses the grid, the first number is greater than the second.
vec2 grid_clip(vec3 from, vec3 way, uint size) { return box_clip(from, way, vec3(0.0), vec3(size)); }

// A way through a grid, mirrored so that its direction is positive along each axis: only the far sides of voxels are needed then.
struct March {
    vec3 from;
    vec3 way;
    vec3 inverse;  // of `way`
    uint size;     // voxels per side, or cells
    uvec3 mirror;  // a mirrored voxel's place XOR this is its place in the grid
    vec2 range;    // within the grid, lengths of `way`
};

// Begins a march over a part of a way, with the first voxel of it. False where the part is empty.
bool march_within(vec3 from, vec3 way, vec2 range, uint size, out March march, out ivec3 voxel) {
    march.range = range;
    bvec3 turned = lessThan(way, vec3(0.0));
    march.size = size;
    march.mirror = uvec3(mix(ivec3(0), ivec3(size - 1u), turned));
    march.from = mix(from, vec3(size) - from, turned);
    march.way = abs(way);
    march.inverse = 1.0 / max(march.way, vec3(1e-20));
    voxel = clamp(ivec3(march.from + march.way * march.range.x), ivec3(0), ivec3(size - 1u));
    return march.range.x <= march.range.y;
}

// Begins a march over all of a way inside the grid. False where the way misses the grid.
bool march_begin(vec3 from, vec3 way, uint size, out March march, out ivec3 voxel) {
    return march_within(from, way, grid_clip(from, way, size), size, march, voxel);
}

// Where the way reaches the far sides of a voxel, or of the 2^shift voxels per side about it that are empty.
vec3 march_planes(March march, ivec3 voxel, uint shift) {
    ivec3 high = ((voxel >> int(shift)) << int(shift)) + (1 << int(shift));
    return (vec3(high) - march.from) * march.inverse;
}

// Goes on to the voxel that the way enters at the nearest of `planes`. False where that is outside of the grid.
bool march_on(March march, vec3 planes, float nearest, uint shift, inout ivec3 voxel) {
    ivec3 low = (voxel >> int(shift)) << int(shift), high = low + (1 << int(shift));
    ivec3 next = clamp(ivec3(march.from + march.way * nearest), low, high - 1);
    voxel = mix(next, high, lessThanEqual(planes, vec3(nearest)));
    return !any(greaterThan(voxel, ivec3(march.size - 1u)));
}
#endif
