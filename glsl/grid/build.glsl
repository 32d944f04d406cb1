// Shared by the passes that fill a grid. Twin: grid::GridPush.
#ifndef GRID_BUILD_GLSL
#define GRID_BUILD_GLSL
#include "grid/grid.glsl"
#include "maps/extents.glsl"
#include "world/triangle.glsl"

layout(push_constant, scalar) uniform GridPush {
    uint triangle_count;
    uint caster_count;
    uint threads;  // number of threads that share triangles and casters in grid.bounds
    uint level;    // level to build in grid.cells
    uint pairs_room;  // for grid.pairs: capacity, in pairs
    uint share;       // for grid.casters: a caster whose box has more than `share` voxels is listed once, for all voxels
    uint fitted;      // for grid.fit: voxels along the longest side of the box about all casters, including two of margin
};

// A shader that only reads defines GRID_ACCESS as `readonly` first: devices need not support writes in vertex shaders.
#ifndef GRID_ACCESS
#define GRID_ACCESS
#endif

// set 0: grid
layout(set = 0, binding = 0, scalar) GRID_ACCESS buffer BuildGrid { Grid grid; };
layout(set = 0, binding = 1, scalar) GRID_ACCESS buffer BuildBits { uint grid_bits[]; };  // two words per 64 bits
layout(set = 0, binding = 2, scalar) readonly buffer BuildTriangles { Triangle triangles[]; };
// Two lists of triangles that cover too many voxels for one thread. listed[LARGE]: number of triangles with one workgroup each.
// listed[HUGE]: number of triangles that all workgroups process together. The indices of large triangles are stored from LISTED on; the
// indices of huge triangles, from the end of the buffer backwards.
layout(set = 0, binding = 3, scalar) GRID_ACCESS buffer BuildLarge { uint listed[]; };

const uint LARGE = 0u;
const uint HUGE = 1u;
const uint LISTED = 2u;
#endif
