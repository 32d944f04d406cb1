// Shared by the passes that fill masks. Twin: grid::masks.
#ifndef GRID_MASKS_SET_GLSL
#define GRID_MASKS_SET_GLSL
#include "grid/build.glsl"
#include "grid/masks.glsl"

// set 1: grid_masks
layout(set = 1, binding = 0, scalar) buffer MasksWords { uint masks[]; };
// Number of occupied voxels, then the number before each run of bricks.
layout(set = 1, binding = 1, scalar) buffer MasksRuns { uint runs[]; };
#endif
