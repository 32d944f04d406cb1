// Which voxels list a triangle: all that it meets, however thin it is and however a ray is rounded, and a few more where rounding makes its
// plane uncertain. Sources: Schwarz and Seidel 2010, section 3; the bounds are ours, docs/notebook/voxel-grid.md derives them. Twin:
// reference::twin::lists, to the bit.
#ifndef GRID_LISTS_MEETS_GLSL
#define GRID_LISTS_MEETS_GLSL

// Voxels are made larger by this to each side, in voxels: more than rounding moves corners, sides and rays.
#define GRID_SLACK (1.0 / 512.0)

#include "grid/facing.glsl"

// The most that rounding may move a triangle's plane, as a factor of about the cube of the triangle's size.
const float PLANE_ROUNDING = 1.0 / 262144.0;

float largest(vec3 of) { return max(abs(of.x), max(abs(of.y), abs(of.z))); }

// The uncertainty of a triangle's plane, in voxels times the length of its normal.
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

// Added to each end of the range of voxels that are tried in a column, in voxels: more than GRID_SLACK and what rounds
// here.
const float RANGE_MARGIN = 0.0625;

// The first and the last voxel of a column that may meet a triangle. Columns stand along the axis that the triangle
// faces most.
ivec2 column_range(Facet facet, float error, uint axis, ivec3 voxel) {
    uint across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    int first = facet.first[axis], last = facet.last[axis];
    vec3 normal = facet.normal, corner = facet.corners[0];
    float along = abs(normal[axis]);
    // If the plane is less certain than the triangle is long, the division below means nothing.
    if (!(along * float(last - first + 1) > error)) {
        return ivec2(first, last);
    }
    vec2 middle = vec2(float(voxel[across]) - corner[across], float(voxel[up]) - corner[up]) + 0.5;
    float at = corner[axis] - (normal[across] * middle.x + normal[up] * middle.y) / normal[axis];
    float reach = 0.5 * (abs(normal[across]) + abs(normal[up])) / along + error / along + RANGE_MARGIN;
    return ivec2(clamp(floor(vec2(at - reach, at + reach)), vec2(first), vec2(last)));
}
#endif
