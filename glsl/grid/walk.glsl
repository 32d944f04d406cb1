// Follows a segment through a grid from voxel to voxel, and skips empty space in one step. Source: after Amanatides and Woo 1987; skipping
// empty space on the levels above is ours. Twin: reference::twin::grid::Bits.
#ifndef GRID_WALK_GLSL
#define GRID_WALK_GLSL
#include "grid/grid.glsl"

bool grid_is_empty(uvec2 bits) { return (bits.x | bits.y) == 0u; }

// The bit of a voxel, brick or block in a word of 64 bits; the last two bits of its position along each axis select it.
bool grid_has(uvec2 bits, uvec3 voxel) {
    uint bit = grid_bit(0u, voxel);
    return ((bit < 32u ? bits.x : bits.y) >> (bit & 31u) & 1u) == 1u;
}

// Whether the octant of a brick that contains a voxel, 2 × 2 × 2 voxels, is empty; likewise for bricks in a block, and for blocks.
bool grid_octant_is_empty(uvec2 bits, uvec3 voxel) {
    uvec3 corner = voxel & 2u;
    return ((corner.z == 0u ? bits.x : bits.y) & (0x00330033u << (corner.x + 4u * corner.y))) == 0u;
}

// Where a segment from `from` along `way` enters and leaves a box, in lengths of `way`, clamped to 0 to 1. If the segment misses the box,
// the first number is greater than the second.
vec2 box_clip(vec3 from, vec3 way, vec3 first, vec3 last) {
    vec3 inverse = 1.0 / mix(way, vec3(1e-20), equal(way, vec3(0.0)));
    vec3 low = (first - from) * inverse, high = (last - from) * inverse;
    vec3 near = min(low, high), far = max(low, high);
    return vec2(max(0.0, max(near.x, max(near.y, near.z))), min(1.0, min(far.x, min(far.y, far.z))));
}

// Where a segment from `from` along `way` enters and leaves a grid of `size` voxels per side, in lengths of `way`, clamped to 0 to 1. If
// the segment misses the grid, the first number is greater than the second.
vec2 grid_clip(vec3 from, vec3 way, uint size) { return box_clip(from, way, vec3(0.0), vec3(size)); }

// A segment through a grid, mirrored so that its direction is positive along each axis: then only the far sides of voxels matter.
struct March {
    vec3 from;
    vec3 way;
    vec3 inverse;  // 1 / `way`
    uint size;     // voxels, or cells, per side
    uvec3 mirror;  // a mirrored voxel's position XOR this is its position in the grid
    vec2 range;    // the part inside the grid, in lengths of `way`
};

// Begins a march over a part of a segment, at the part's first voxel. False if the part is empty.
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

// Begins a march over the part of a segment inside the grid. False if the segment misses the grid.
bool march_begin(vec3 from, vec3 way, uint size, out March march, out ivec3 voxel) {
    return march_within(from, way, grid_clip(from, way, size), size, march, voxel);
}

// Where the segment reaches the far sides of a voxel, or of the empty cube around it, 2^shift voxels per side.
vec3 march_planes(March march, ivec3 voxel, uint shift) {
    ivec3 high = ((voxel >> int(shift)) << int(shift)) + (1 << int(shift));
    return (vec3(high) - march.from) * march.inverse;
}

// Advances to the voxel that the segment enters at the nearest of `planes`. False if that is outside the grid.
bool march_on(March march, vec3 planes, float nearest, uint shift, inout ivec3 voxel) {
    ivec3 low = (voxel >> int(shift)) << int(shift), high = low + (1 << int(shift));
    ivec3 next = clamp(ivec3(march.from + march.way * nearest), low, high - 1);
    voxel = mix(next, high, lessThanEqual(planes, vec3(nearest)));
    return !any(greaterThan(voxel, ivec3(march.size - 1u)));
}
#endif
