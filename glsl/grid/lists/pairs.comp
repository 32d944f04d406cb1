#version 460
// Marks every voxel that a triangle touches as occupied, and records the pair of voxel and triangle. See-through triangles are left out, and
// holes are not: a look-up decides at the hit. One thread per triangle. Triangles
// that touch many voxels are listed, and later variants process them: one workgroup per triangle (STEP 1), or all workgroups together (STEP
// 2). A workgroup reserves space for all of its pairs at once. Source: ours, after Schwarz and Seidel 2010. Inputs: triangles, grid.
// Outputs: bits of all levels, pairs and their number, the lists of large triangles. Twin: reference::twin::lists. Invariant: the same
// pairs in some order; pairs beyond the capacity are counted.
// variants: STEP 0 1 2
layout(local_size_x = 64) in;
#include "grid/lists/meets.glsl"
#include "grid/lists/note.glsl"

// SMALL: largest number of voxels in a triangle's box that one thread processes. COLUMNS: largest number of a triangle's columns of voxels
// that one workgroup processes. Other limits give the same pairs.
const uint SMALL = 64u;
const uint COLUMNS = 4096u;

// Records the voxels in the columns of a listed triangle, 64 columns at a time, from `first` on.
void columns(uint i, uint first, uint step) {
    Facet facet = facet_at(i);
    float error = plane_error(facet);
    uint axis = facet_axis(facet), across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    ivec3 box = facet.last - facet.first + 1;
    uint count = uint(box[across] * box[up]);
    for (uint begin = first; begin < count; begin += step) {
        uint column = begin + gl_LocalInvocationIndex, met = 0u;
        ivec3 voxel = facet.first;
        voxel[across] += int(column) % box[across];
        voxel[up] += int(column) / box[across];
        ivec2 range = column < count ? column_range(facet, error, axis, voxel) : ivec2(0, -1);
        // At most four voxels of a column touch the triangle, unless its plane is too uncertain: then all of them may.
        uint mask = 0u;
        for (int v = range.x; v <= range.y; ++v) {
            voxel[axis] = v;
            if (listed_in(facet, error, voxel)) {
                ++met;
                mask |= v - range.x < 32 ? 1u << (v - range.x) : 0u;
            }
        }
        uint at = place_of(met);
        for (int v = range.x; v <= range.y && met > 0u; ++v) {
            voxel[axis] = v;
            if (v - range.x < 32 ? (mask >> (v - range.x) & 1u) == 1u : listed_in(facet, error, voxel)) {
                note(at++, i, uvec3(voxel), low_of(facet), high_of(facet));
            }
        }
    }
}

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    if (STEP == 1) {
        for (uint l = group; l < listed[LARGE]; l += groups) {
            columns(listed[LISTED + l], 0u, 64u);
        }
        return;
    }
    if (STEP == 2) {
        for (uint l = 0u; l < listed[HUGE]; ++l) {
            columns(listed[LISTED + triangle_count - 1u - l], 64u * group, 64u * groups);
        }
        return;
    }
    uint i = 64u * group + thread, voxels = 0u;
    uvec2 met = uvec2(0u);
    Facet facet;
    ivec3 box = ivec3(1);
    if (i < triangle_count) {
        facet = facet_at(i);
        box = facet.last - facet.first + 1;
        voxels = facet_is_point(facet) || alpha_sees_through(i) ? 0u : uint(box.x * box.y * box.z);
        if (voxels > SMALL) {
            voxels = 0u;
            int widest = max(box.x * box.y, max(box.y * box.z, box.z * box.x));
            if (uint(widest) > COLUMNS) {
                listed[LISTED + triangle_count - 1u - atomicAdd(listed[HUGE], 1u)] = i;
            } else {
                listed[LISTED + atomicAdd(listed[LARGE], 1u)] = i;
            }
        }
        float error = plane_error(facet);
        for (uint v = 0u; v < voxels; ++v) {
            ivec3 voxel = facet.first + ivec3(int(v) % box.x, int(v) / box.x % box.y, int(v) / (box.x * box.y));
            if (listed_in(facet, error, voxel)) {
                uint bit = 1u << (v & 31u);
                met |= v < 32u ? uvec2(bit, 0u) : uvec2(0u, bit);
            }
        }
    }
    uint at = place_of(uint(bitCount(met.x) + bitCount(met.y)));
    while (met != uvec2(0u)) {
        uint v = met.x != 0u ? uint(findLSB(met.x)) : 32u + uint(findLSB(met.y));
        met = met.x != 0u ? uvec2(met.x & (met.x - 1u), met.y) : uvec2(0u, met.y & (met.y - 1u));
        ivec3 voxel = facet.first + ivec3(int(v) % box.x, int(v) / box.x % box.y, int(v) / (box.x * box.y));
        note(at++, i, uvec3(voxel), low_of(facet), high_of(facet));
    }
}
