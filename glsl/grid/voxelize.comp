#version 460
// Sets the bit of every voxel that a triangle overlaps. One thread per triangle. Triangles that overlap many voxels are listed, and later
// variants process them: one workgroup per triangle (STEP 1), or all workgroups together (STEP 2). Source: ours, after Schwarz and Seidel
// 2010. Inputs: triangles, grid. Output: bits of all levels, the lists. Twin: reference::twin::grid::voxelize. Invariant: the result does
// not depend on the order of threads, so every run gives the same bytes; a bit of a higher level is set if the word below it has a bit.
// variants: STEP 0 1 2
#include "grid/occupy.glsl"
#include "grid/share.glsl"
