#version 460
// Sets the bit of every mask cell that a triangle touches, as grid/voxelize.comp does for voxels. Source: ours, after Schwarz and Seidel
// 2010. Inputs: triangles, grid, bits. Outputs: masks, the lists. Twin: reference::twin::masks::Masks. Invariant: the result does not
// depend on the order of threads, so every run gives the same bytes.
// variants: STEP 0 1 2
#include "grid/occupy_cell.glsl"
#include "grid/share.glsl"
