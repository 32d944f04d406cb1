// Shared by the passes that fill a grid. Twin: grid::GridPush.
#ifndef GRID_BUILD_GLSL
#define GRID_BUILD_GLSL
#include "grid/grid.glsl"
#include "maps/extents.glsl"
#include "world/triangle.glsl"

layout(push_constant, scalar) uniform GridPush {
    uint triangle_count;
    uint caster_count;
    uint threads;  // that share triangles and casters in grid.bounds
    uint level;    // of grid.cells
    uint pairs_room;  // of grid.pairs: pairs that there is room for
    uint share;       // of grid.casters: a caster whose box has more voxels is listed once, for all voxels
    uint fitted;      // of grid.fit: voxels along the longest side of the box about all casters, two of them beside it
};

// A shader that only reads defines GRID_ACCESS as `readonly` first: a device need not let vertex shaders write.
#ifndef GRID_ACCESS
#define GRID_ACCESS
#endif

// set 0: grid
layout(set = 0, binding = 0, scalar) GRID_ACCESS buffer BuildGrid { Grid grid; };
layout(set = 0, binding = 1, scalar) GRID_ACCESS buffer BuildBits { uint grid_bits[]; };  // two words for 64 bits
layout(set = 0, binding = 2, scalar) readonly buffer BuildTriangles { Triangle triangles[]; };
// Two lists of triangles that have too many voxels for one thread. listed[LARGE]: how many triangles are taken by one workgroup each.
// listed[HUGE]: how many triangles all workgroups take together. The numbers of the former stand from LISTED on, the numbers of the latter
// from the end of the buffer backwards.
layout(set = 0, binding = 3, scalar) GRID_ACCESS buffer BuildLarge { uint listed[]; };

const uint LARGE = 0u;
const uint HUGE = 1u;
const uint LISTED = 2u;
#endif
