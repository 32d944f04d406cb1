// Shared by the passes that put casters into a grid. Twin: grid::media.
#ifndef GRID_CAST_GLSL
#define GRID_CAST_GLSL
#include "grid/build.glsl"
#include "grid/blob.glsl"

// set 1: grid_cast
layout(set = 1, binding = 0, scalar) readonly buffer CastCasters { Caster casters[]; };
layout(set = 1, binding = 1, scalar) buffer CastMedia { uint media[]; };
layout(set = 1, binding = 2, scalar) buffer CastBits { uint media_bits[]; };
// Casters that cover too many voxels for one thread, listed as triangles are in glsl/grid/build.glsl.
layout(set = 1, binding = 3, scalar) buffer CastLarge { uint cast_listed[]; };
#endif
