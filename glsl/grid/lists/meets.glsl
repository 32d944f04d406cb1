// Voxels that list a triangle: all that it touches, however thin it is and however rays are rounded, and a few more if rounding makes its
// plane uncertain. Sources: Schwarz and Seidel 2010, section 3; the bounds are ours, docs/notebook/voxel-grid.md derives them. Twin:
// reference::twin::lists, bit for bit.
#ifndef GRID_LISTS_MEETS_GLSL
#define GRID_LISTS_MEETS_GLSL

// Margin, in voxels, added to voxels on each side; it exceeds the rounding error of corners, sides and rays.
#define GRID_SLACK (1.0 / 512.0)

#include "grid/facing.glsl"

// Error bound of a triangle's rounded plane, as a factor of roughly the cube of the triangle's size.
const float PLANE_ROUNDING = 1.0 / 262144.0;

float largest(vec3 of) { return max(abs(of.x), max(abs(of.y), abs(of.z))); }

// Returns the error bound of a triangle's rounded plane, in voxels times the length of its normal.
float plane_error(Facet facet) {
    float side = max(largest(facet.edges[0]), max(largest(facet.edges[1]), largest(facet.edges[2])));
    precise float error = PLANE_ROUNDING * (side * side) * (side + 2.0);
    return error;
}

// Whether a voxel of the triangle's box lists the triangle.
bool listed_in(Facet facet, float error, ivec3 voxel) {
    vec3 corner = vec3(voxel), normal = facet.normal;
    precise vec3 a = facet.corners[0] - corner;
    precise float plane = normal.x * a.x + normal.y * a.y + normal.z * a.z;
    precise float most = max(normal.x, 0.0) + max(normal.y, 0.0) + max(normal.z, 0.0);
    precise float least = min(normal.x, 0.0) + min(normal.y, 0.0) + min(normal.z, 0.0);
    precise float slack = GRID_SLACK * (abs(normal.x) + abs(normal.y) + abs(normal.z)) + error;
    precise float above = most + slack - plane, below = plane - least + slack;
    return above >= 0.0 && below >= 0.0 && facet_meets_sides(facet, voxel);
}

// Margin, in voxels, at each end of the range of voxels tested in a column: more than GRID_SLACK plus the rounding error of column_range.
const float RANGE_MARGIN = 0.0625;

// First and last voxel of a column that may touch a triangle. Columns run along the axis that the triangle faces most.
ivec2 column_range(Facet facet, float error, uint axis, ivec3 voxel) {
    uint across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    int first = facet.first[axis], last = facet.last[axis];
    vec3 normal = facet.normal, corner = facet.corners[0];
    float along = abs(normal[axis]);
    // If the plane's error bound exceeds the triangle's extent, the division below is meaningless.
    if (!(along * float(last - first + 1) > error)) {
        return ivec2(first, last);
    }
    vec2 middle = vec2(float(voxel[across]) - corner[across], float(voxel[up]) - corner[up]) + 0.5;
    float at = corner[axis] - (normal[across] * middle.x + normal[up] * middle.y) / normal[axis];
    float reach = 0.5 * (abs(normal[across]) + abs(normal[up])) / along + error / along + RANGE_MARGIN;
    return ivec2(clamp(floor(vec2(at - reach, at + reach)), vec2(first), vec2(last)));
}
#endif
