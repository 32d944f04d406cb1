#version 460
// Sets the bit of every voxel of a column that a triangle overlaps. Source: Schwarz and Seidel 2010, section 3; the exact test that decides
// is ours. Inputs: triangles, grid, fragments from glsl/grid/voxelize.vert. Output: bits of all levels. Twin:
// reference::twin::grid::Bits::voxelize. Invariant: the same bytes as from glsl/grid/voxelize.comp. With MASK the shader sets cells of
// masks instead, and gives the same bytes as glsl/grid/mask.comp.
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
