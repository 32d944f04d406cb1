#version 460
// Sums the directions of strands in the voxels that they cross. One thread per strand. Source: ours. Inputs: casters, grid. Output:
// directions. Twin: reference::twin::soft::Directions. Invariant: the sums are of integers, so every run gives the same bytes.
layout(local_size_x = 64) in;
#include "grid/cast.glsl"
#include "grid/directions.glsl"

// set 2: grid_directions
layout(set = 2, binding = 0, scalar) buffer CastDirections { int directions[]; };

// The strand's direction: squares of its coordinates, and products of pairs of different coordinates.
vec3 squares;
vec3 products;

void add(uint at, float amount, float product) {
    precise float units = amount * product;
    int whole = int(units);
    if (whole != 0) {
        atomicAdd(directions[at], whole);
    }
}

void deposit(uvec3 voxel, uint amount) {
    // The conversion itself is exact: a float holds 24 bits, so amounts of more bits first drop their lowest 8.
    precise float exact = amount < 16777216u ? float(amount) : float(amount >> 8) * 256.0;
    precise float units = exact * (DIRECTION_UNITS / MEDIA_UNITS);
    uint at = 6u * media_at(grid.size, voxel);
    for (uint i = 0u; i < 3u && amount > 0u; ++i) {
        add(at + i, units, squares[i]);
        add(at + 3u + i, units, products[i]);
    }
}

#include "grid/mote.glsl"

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (i >= caster_count || !caster_is_strand(casters[i])) {
        return;
    }
    Caster caster = casters[i];
    precise vec3 place = (caster.position - grid.origin) * grid.per_unit, axis = caster.axis * grid.per_unit;
    precise float radius = caster.radius * grid.per_unit;
    precise float square = axis.x * axis.x + axis.y * axis.y + axis.z * axis.z;
    precise vec3 run = axis * inverse_root(square);
    precise vec3 of_squares = run * run, of_products = run * run.yzx;
    squares = of_squares;
    products = of_products;
    Motes motes = strand_motes(place, axis, radius, caster.density);
    for (uint m = 0u; m < motes.count; ++m) {
        deposit_mote(mote_place(motes, m), motes.amount);
    }
}
