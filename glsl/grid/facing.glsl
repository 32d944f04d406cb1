// Triangles in a grid's coordinates, and the axis that each faces most: seen along that axis, only degenerate triangles are edge-on. Twin:
// reference::twin::grid::Facet.
#ifndef GRID_FACING_GLSL
#define GRID_FACING_GLSL
#include "grid/build.glsl"
#include "grid/overlap.glsl"
#include "world/alpha_cover.glsl"

// A triangle in voxels, or in mask cells, FACET_CELLS per side of a voxel.
Facet facet_at(uint i) {
    Triangle triangle = triangles[i];
    precise vec3 a = (triangle.corners[0] - grid.origin) * grid.per_unit;
    precise vec3 b = (triangle.corners[1] - grid.origin) * grid.per_unit;
    precise vec3 c = (triangle.corners[2] - grid.origin) * grid.per_unit;
    Facet facet = facet_of(FACET_CELLS * a, FACET_CELLS * b, FACET_CELLS * c, FACET_CELLS * grid.size);
    facet.number = i;
    return facet;
}

// Whether a triangle overlaps a voxel of its box, and may block light there.
bool facet_occupies(Facet facet, ivec3 voxel) {
    return facet_meets(facet, voxel) && alpha_covers(facet.number, facet.corners, vec3(voxel), 1.0);
}

uint facet_axis(Facet facet) {
    vec3 facing = abs(facet.normal);
    return facing.x >= facing.y && facing.x >= facing.z ? 0u : facing.y >= facing.z ? 1u : 2u;
}
#endif
