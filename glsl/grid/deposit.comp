#version 460
// Adds smoke, hair, splats, sheets and volumes to the voxels that they overlap. One thread per caster; casters with many parts are listed,
// and the later variants process them: one workgroup per caster (STEP 1), or all workgroups together (STEP 2). Source: ours. Inputs: casters, grid.
// Outputs: media, their bits, the lists. Twin: reference::twin::media::deposit. Invariant: the sums are of integers, so every run gives the
// same bytes; a sum that overflows 32 bits does so in any order, and sets its voxel's bit.
// variants: STEP 0 1 2
layout(local_size_x = 64) in;
#include "grid/cast.glsl"

// SMALL: largest number of parts of a caster that one thread processes; parts are the voxels of a sphere's box or the points of a strand or
// sheet. BOXED: largest number that one workgroup processes. Other limits give the same bytes.
const uint SMALL = 64u;
const uint BOXED = 262144u;

void deposit(uvec3 voxel, uint amount) {
    if (amount == 0u) {
        return;
    }
    uint before = atomicAdd(media[media_at(grid.size, voxel)], amount);
    if (before + amount < before) {
        uint full = grid_bit(0u, voxel);
        atomicOr(media_bits[2u * grid_word(grid.size, 0u, voxel) + (full >> 5)], 1u << (full & 31u));
    }
    // The thread that adds the first amount to a voxel sets the bits on the levels above.
    for (uint level = 1u; level < GRID_LEVELS && before == 0u; ++level) {
        uint bit = grid_bit(level, voxel), word = 2u * grid_word(grid.size, level, voxel) + (bit >> 5);
        uint mask = 1u << (bit & 31u);
        if ((media_bits[word] & mask) != 0u || atomicOr(media_bits[word], mask) != 0u) {
            return;
        }
    }
}

#include "grid/bell.glsl"
#include "grid/cell.glsl"
#include "grid/mote.glsl"
#include "grid/pane.glsl"

// Deposits every `step`-th part (voxel or point) of a caster from `first` on, unless the caster has more than `most` parts. Returns its
// number of parts.
uint deposit_caster(uint i, uint first, uint step, uint most) {
    Caster caster = casters[i];
    precise vec3 place = (caster.position - grid.origin) * grid.per_unit;
    precise float radius = caster.radius * grid.per_unit;
    bool strand = caster_is_strand(caster);
    if (caster_is_splat(caster)) {
        Bell bell = bell_of(place, radius, caster.axis, caster.density * grid.voxel, grid.size);
        uint all = bell_count(bell);
        for (uint v = first; v < all && all <= most; v += step) {
            uvec3 of = bell_place(bell, v);
            if (bell.thick) {
                deposit(uvec3(bell.first) + of, bell_amount(bell, bell.first + ivec3(of)));
                continue;
            }
            vec3 at, half_sides;
            float amount = bell_part(bell, of, at, half_sides);
            BellVoxels voxels = bell_voxels(at, half_sides, grid.size);
            for (uint corner = 0u; corner < 8u; ++corner) {
                uvec3 voxel;
                float share = bell_in(voxels, corner, voxel);
                if (share > 0.0) {
                    deposit(voxel, bell_units(amount * share));
                }
            }
        }
        return all;
    }
    if (caster_is_cell(caster)) {
        Slab slab = slab_of(place, radius, caster.axis, caster.density * grid.voxel, grid.size);
        uvec3 box = uvec3(slab.last - slab.first + 1);
        uint voxels = box.x * box.y * box.z;
        for (uint v = first; v < voxels && voxels <= most; v += step) {
            ivec3 voxel = slab.first + ivec3(v % box.x, v / box.x % box.y, v / (box.x * box.y));
            deposit(uvec3(voxel), slab_amount(slab, voxel));
        }
        return voxels;
    }
    if (caster_is_sheet(caster)) {
        Pane pane = pane_of(caster);
        uint all = pane_count(pane);
        for (uint m = first; m < all && all <= most; m += step) {
            vec2 at = pane_weights(pane, m);
            deposit_mote(pane_place(pane, at), pane_amount(pane, caster, at));
        }
        return all;
    }
    if (!strand && radius >= 1.0) {
        precise float extinction = caster.density * grid.voxel;
        Ball ball = ball_of(place, radius, extinction, grid.size);
        uvec3 box = uvec3(ball.last - ball.first + 1);
        uint voxels = box.x * box.y * box.z;
        for (uint v = first; v < voxels && voxels <= most; v += step) {
            ivec3 voxel = ball.first + ivec3(v % box.x, v / box.x % box.y, v / (box.x * box.y));
            deposit(uvec3(voxel), ball_amount(ball, voxel));
        }
        return voxels;
    }
    Motes motes;
    if (strand) {
        precise vec3 axis = caster.axis * grid.per_unit;
        motes = strand_motes(place, axis, radius, caster.density);
    } else {
        precise float extinction = caster.density * grid.voxel;
        motes = sphere_motes(place, radius, extinction);
    }
    for (uint m = first; m < motes.count && motes.count <= most; m += step) {
        deposit_mote(mote_place(motes, m), motes.amount);
    }
    return motes.count;
}

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    if (STEP == 1) {
        for (uint l = group; l < cast_listed[LARGE]; l += groups) {
            deposit_caster(cast_listed[LISTED + l], thread, 64u, 0xFFFFFFFFu);
        }
        return;
    }
    if (STEP == 2) {
        for (uint l = 0u; l < cast_listed[HUGE]; ++l) {
            deposit_caster(cast_listed[LISTED + caster_count - 1u - l], 64u * group + thread, 64u * groups, 0xFFFFFFFFu);
        }
        return;
    }
    uint i = 64u * group + thread;
    if (i >= caster_count) {
        return;
    }
    uint voxels = deposit_caster(i, 0u, 1u, SMALL);
    if (voxels > BOXED) {
        cast_listed[LISTED + caster_count - 1u - atomicAdd(cast_listed[HUGE], 1u)] = i;
    } else if (voxels > SMALL) {
        cast_listed[LISTED + atomicAdd(cast_listed[LARGE], 1u)] = i;
    }
}
