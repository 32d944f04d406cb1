#version 460
// Sets the bit of every voxel that a triangle meets. One thread per triangle; those that meet many voxels are listed, and in the
// variants behind it a workgroup takes each (STEP 1), or all workgroups do (STEP 2). Source: ours, after Schwarz and Seidel 2010.
// Inputs: triangles, grid. Output: bits of all levels, the lists. Twin: reference::twin::grid::voxelize.
// Invariant: a bit is set whichever comes first, so the same bytes each run; a word above is set where a word below has
// a bit.
// variants: STEP 0 1 2
#include "grid/occupy.glsl"
#include "grid/share.glsl"
