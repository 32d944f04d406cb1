// Finds the voxels, or mask cells, of a column that intersect a triangle, and calls `occupy` for each. Twin: reference::twin::grid::Bits.
#ifndef GRID_COLUMN_GLSL
#define GRID_COLUMN_GLSL

// Margin, in voxels, at each end of the range of voxels tested in a column: a thousand times the rounding error.
const float COLUMN_MARGIN = 0.0625;

// If the normal's component along the column is smaller than this, dividing by it does not locate the plane.
const float LEAST_NORMAL = 1e-30;

// Finds the voxels of a column that intersect a triangle. Columns run along the axis that the triangle faces most, so that its plane
// crosses at most three of a column's voxels. Only these are tested, not the triangle's whole box.
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
        if (facet_occupies(facet, voxel)) {
            occupy(uvec3(voxel));
        }
    }
}
#endif
