// Distributes triangles among threads, by the number of voxels, or cells, in their boxes. Needs `occupy`.
#ifndef GRID_SHARE_GLSL
#define GRID_SHARE_GLSL
#include "grid/column.glsl"

layout(local_size_x = 64) in;

// SMALL: largest number of voxels in a triangle's box that one thread processes. COLUMNS: largest number of a triangle's columns of voxels
// that one workgroup processes. Other limits give the same bits.
const uint SMALL = 64u;
const uint COLUMNS = 4096u;

// Occupies the voxels of a listed triangle, in every `step`-th column from `first` on. Columns run along the axis that the triangle faces
// most.
void fill(uint i, uint first, uint step) {
    Facet facet = facet_at(i);
    uint axis = facet_axis(facet);
    uint across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    ivec3 box = facet.last - facet.first + 1;
    uint columns = uint(box[across] * box[up]);
    for (uint column = first; column < columns; column += step) {
        ivec3 voxel = facet.first;
        voxel[across] += int(column) % box[across];
        voxel[up] += int(column) / box[across];
        occupy_column(facet, axis, voxel);
    }
}

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    if (STEP == 1) {
        for (uint l = group; l < listed[LARGE]; l += groups) {
            fill(listed[LISTED + l], thread, 64u);
        }
        return;
    }
    if (STEP == 2) {
        for (uint l = 0u; l < listed[HUGE]; ++l) {
            fill(listed[LISTED + triangle_count - 1u - l], 64u * group + thread, 64u * groups);
        }
        return;
    }
    uint i = 64u * group + thread;
    if (i >= triangle_count) {
        return;
    }
    Facet facet = facet_at(i);
    if (facet_is_point(facet)) {
        return;
    }
    ivec3 box = facet.last - facet.first + 1;
    int voxels = box.x * box.y * box.z;
    if (uint(voxels) > SMALL) {
        int widest = max(box.x * box.y, max(box.y * box.z, box.z * box.x));
        if (uint(widest) > COLUMNS) {
            listed[LISTED + triangle_count - 1u - atomicAdd(listed[HUGE], 1u)] = i;
        } else {
            listed[LISTED + atomicAdd(listed[LARGE], 1u)] = i;
        }
        return;
    }
    for (int v = 0; v < voxels; ++v) {
        ivec3 voxel = facet.first + ivec3(v % box.x, v / box.x % box.y, v / (box.x * box.y));
        if (facet_occupies(facet, voxel)) {
            occupy(uvec3(voxel));
        }
    }
}
#endif
