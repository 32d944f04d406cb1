#version 460
// Sums the directions of strands in the voxels that they cross, or with FACING the normals of sheets. One thread per strand, one workgroup
// per sheet. Source: ours. Inputs: casters, grid. Output: directions. Twin: reference::twin::soft::Directions. Invariant: the sums are of
// integers, so every run gives the same bytes.
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
#include "grid/pane.glsl"

void set_direction(vec3 run) {
    precise vec3 of_squares = run * run, of_products = run * run.yzx;
    squares = of_squares;
    products = of_products;
}

void add_sheet(Caster sheet) {
    Pane pane = pane_of(sheet);
    vec3 b = pane.b, c = pane.c;
    precise vec3 normal = vec3(b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x);
    precise float square = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    precise vec3 run = normal * inverse_root(square);
    set_direction(run);
    for (uint m = gl_LocalInvocationIndex; m < pane_count(pane); m += 64u) {
        vec2 at = pane_weights(pane, m);
        deposit_mote(pane_place(pane, at), pane_amount(pane, sheet, at));
    }
}

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, i = 64u * group + gl_LocalInvocationIndex;
    if (FACING && group < caster_count && caster_is_sheet(casters[group])) {
        add_sheet(casters[group]);
    }
    if (FACING || i >= caster_count || !caster_is_strand(casters[i])) {
        return;
    }
    Caster caster = casters[i];
    precise vec3 place = (caster.position - grid.origin) * grid.per_unit, axis = caster.axis * grid.per_unit;
    precise float radius = caster.radius * grid.per_unit;
    precise float square = axis.x * axis.x + axis.y * axis.y + axis.z * axis.z;
    precise vec3 run = axis * inverse_root(square);
    set_direction(run);
    Motes motes = strand_motes(place, axis, radius, caster.density);
    for (uint m = 0u; m < motes.count; ++m) {
        deposit_mote(mote_place(motes, m), motes.amount);
    }
}
