// Finds the voxels, or mask cells, of a column that a triangle meets, and calls `occupy` for each. Twin: reference::twin::grid::Bits.
#ifndef GRID_COLUMN_GLSL
#define GRID_COLUMN_GLSL

// Added to each end of the range of voxels that are tried in a column, in voxels: a thousand times what rounding
// changes.
const float COLUMN_MARGIN = 0.0625;

// If the normal is shorter than this along the column, dividing by it says nothing about the plane.
const float LEAST_NORMAL = 1e-30;

// Finds the voxels of a column that a triangle meets. Columns stand along the axis that the triangle faces most, so that its
// plane goes through three of a column's voxels at most. Only these are tested, and not all of the triangle's box.
void occupy_column(Facet facet, uint axis, ivec3 voxel) {
    uint across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    int first = facet.first[axis], last = facet.last[axis];
    vec3 normal = facet.normal, corner = facet.corners[0];
    float along = abs(normal[axis]);
    if (along > LEAST_NORMAL) {
        vec2 middle = vec2(float(voxel[across]) - corner[across], float(voxel[up]) - corner[up]) + 0.5;
        float at = corner[axis] - (normal[across] * middle.x + normal[up] * middle.y) / normal[axis];
        float reach = 0.5 * (abs(normal[across]) + abs(normal[up])) / along + COLUMN_MARGIN;
        first = int(clamp(floor(at - reach), float(first), float(last)));
        last = int(clamp(floor(at + reach), float(first), float(last)));
    }
    for (voxel[axis] = first; voxel[axis] <= last; ++voxel[axis]) {
        if (facet_meets(facet, voxel)) {
            occupy(uvec3(voxel));
        }
    }
}
#endif
