#version 460
// Sets the bit of every voxel of a column that a triangle meets. Source: Schwarz and Seidel 2010, section 3; deciding by the exact test is
// ours. Inputs: triangles, grid, what glsl/grid/voxelize.vert drew. Output: bits of all levels. Twin:
// reference::twin::grid::Bits::voxelize. Invariant: the same bytes as glsl/grid/voxelize.comp makes. With MASK the shader sets cells of
// masks instead, and makes the same bytes as glsl/grid/mask.comp.
// variants: MASK 0 1
#if MASK == 1
#include "grid/occupy_cell.glsl"
#else
#include "grid/occupy.glsl"
#endif
#include "grid/column.glsl"

layout(location = 0) flat in uint triangle;

void main() {
    Facet facet = facet_at(triangle);
    uint axis = facet_axis(facet), across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    ivec3 voxel = facet.first;
    voxel[across] = int(gl_FragCoord.x);
    voxel[up] = int(gl_FragCoord.y);
    if (all(greaterThanEqual(voxel, facet.first)) && all(lessThanEqual(voxel, facet.last))) {
        occupy_column(facet, axis, voxel);
    }
}
