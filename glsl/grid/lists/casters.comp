#version 460
// Marks every voxel that a caster overlaps as occupied, and records the pair of voxel and caster. One thread per caster. Casters whose
// boxes have too many voxels for one thread are listed, and later variants process them: one workgroup each (STEP 1), or all workgroups
// together (STEP 2). A caster whose box has more than `share` voxels is recorded once, for all voxels. Source: ours; segments against boxes
// after Ericson 2005, 5.3.3. Inputs: casters, grid. Outputs: bits of all levels, pairs and their number, the lists of large casters. Twin:
// reference::twin::lists. Invariants: the same pairs in some order; pairs beyond the capacity are counted; no caster has more than `share`
// pairs.
// variants: STEP 0 1 2
layout(local_size_x = 64) in;
#include "grid/lists/note.glsl"
#include "world/caster.glsl"

// set 2: grid_cast_lists
layout(set = 2, binding = 0, scalar) readonly buffer ListsCasters { Caster casters[]; };

// Largest number of voxels in a caster's box that one thread processes, and that one workgroup processes. Other limits give the same pairs.
const uint SMALL = 64u;
const uint BOXED = 262144u;

// Margin, in voxels, added to casters on each side; it exceeds the rounding error of casters and rays.
const float CAST_SLACK = 1.0 / 512.0;

// A caster in voxels: a sphere, or a capsule about a segment.
struct Cast {
    vec3 place;
    vec3 axis;
    float reach;
    vec3 low;     // corners of its box
    vec3 high;
    ivec3 first;  // first voxel of the box
    ivec3 box;
};

Cast cast_of(Caster caster) {
    Cast c;
    precise vec3 place = (caster.position - grid.origin) * grid.per_unit;
    precise vec3 axis = caster_axis(caster) * grid.per_unit;
    precise float reach = caster.radius * grid.per_unit + CAST_SLACK;
    precise vec3 low = min(place, place + axis) - reach, high = max(place, place + axis) + reach;
    c.place = place;
    c.axis = axis;
    c.reach = reach;
    c.low = low;
    c.high = high;
    c.first = ivec3(clamp(floor(low), vec3(0.0), vec3(grid.size - 1u)));
    c.box = ivec3(clamp(floor(high), vec3(0.0), vec3(grid.size - 1u))) - c.first + 1;
    return c;
}

// A sphere is tested by its distance; a capsule conservatively, by its segment against an enlarged voxel.
bool cast_meets(Cast c, ivec3 voxel) {
    precise vec3 middle = c.place - (vec3(voxel) + 0.5);
    if (c.axis == vec3(0.0)) {
        precise vec3 apart = max(abs(middle) - 0.5, vec3(0.0));
        precise float square = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
        precise float reach = c.reach * c.reach;
        return square <= reach;
    }
    precise vec3 along = 0.5 * c.axis;
    precise vec3 from = middle + along;
    precise float half_side = 0.5 + c.reach;
    vec3 length = abs(along);
    precise vec3 sides = half_side + length;
    if (any(greaterThan(abs(from), sides))) {
        return false;
    }
    precise vec3 across = abs(from.yzx * along.zxy - from.zxy * along.yzx);
    precise vec3 most = half_side * (length.zxy + length.yzx) + CAST_SLACK * (length.x + length.y + length.z);
    return all(lessThanEqual(across, most));
}

ivec3 voxel_of(Cast c, uint v) {
    return c.first + ivec3(int(v) % c.box.x, int(v) / c.box.x % c.box.y, int(v) / (c.box.x * c.box.y));
}

// Records the voxels of a listed caster, 64 at a time, from `first` on.
void boxes(uint i, uint first, uint step) {
    Cast c = cast_of(casters[i]);
    uint count = uint(c.box.x * c.box.y * c.box.z);
    for (uint begin = first; begin < count; begin += step) {
        uint v = begin + gl_LocalInvocationIndex;
        bool met = v < count && cast_meets(c, voxel_of(c, v));
        uint at = place_of(uint(met));
        if (met) {
            note(at, i, uvec3(voxel_of(c, v)), c.low, c.high);
        }
    }
}

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    if (STEP == 1) {
        for (uint l = group; l < listed[LARGE]; l += groups) {
            boxes(listed[LISTED + l], 0u, 64u);
        }
        return;
    }
    if (STEP == 2) {
        for (uint l = 0u; l < listed[HUGE]; ++l) {
            boxes(listed[LISTED + caster_count - 1u - l], 64u * group, 64u * groups);
        }
        return;
    }
    uint i = 64u * group + thread, voxels = 0u;
    uvec2 met = uvec2(0u);
    bool for_all = false;
    Cast c;
    // A caster of radius 0 casts no shadow.
    if (i < caster_count && casters[i].radius > 0.0) {
        c = cast_of(casters[i]);
        voxels = uint(c.box.x * c.box.y * c.box.z);
        for_all = voxels > share;
        if (for_all) {
            voxels = 0u;
        } else if (voxels > BOXED) {
            listed[LISTED + caster_count - 1u - atomicAdd(listed[HUGE], 1u)] = i;
        } else if (voxels > SMALL) {
            listed[LISTED + atomicAdd(listed[LARGE], 1u)] = i;
        }
        for (uint v = 0u; v < voxels && voxels <= SMALL; ++v) {
            if (cast_meets(c, voxel_of(c, v))) {
                uint bit = 1u << (v & 31u);
                met |= v < 32u ? uvec2(bit, 0u) : uvec2(0u, bit);
            }
        }
    }
    uint at = place_of(uint(for_all) + uint(bitCount(met.x) + bitCount(met.y)));
    if (for_all) {
        note_for_all(at, i);
    }
    while (met != uvec2(0u)) {
        uint v = met.x != 0u ? uint(findLSB(met.x)) : 32u + uint(findLSB(met.y));
        met = met.x != 0u ? uvec2(met.x & (met.x - 1u), met.y) : uvec2(0u, met.y & (met.y - 1u));
        note(at++, i, uvec3(voxel_of(c, v)), c.low, c.high);
    }
}
