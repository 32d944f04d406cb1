// What the passes share that fill a grid. Twin: grid::GridPush.
#ifndef GRID_BUILD_GLSL
#define GRID_BUILD_GLSL
#include "grid/grid.glsl"
#include "maps/extents.glsl"
#include "world/triangle.glsl"

layout(push_constant, scalar) uniform GridPush {
    uint triangle_count;
    uint threads;  // that share the triangles in grid.bounds
};

layout(set = 0, binding = 0, scalar) buffer BuildGrid { Grid grid; };
layout(set = 0, binding = 1, scalar) buffer BuildBits { uint grid_bits[]; };  // two words for 64 bits
layout(set = 0, binding = 2, scalar) readonly buffer BuildTriangles { Triangle triangles[]; };
// How many triangles meet more voxels than one thread goes through: those that are a workgroup's, those that all workgroups share;
// then the first from the front, the others from the end.
layout(set = 0, binding = 3, scalar) buffer BuildLarge {
    uint large;
    uint huge;
    uint listed[];
};
#endif
