// Smoke and hair in the voxels of a grid. Each voxel has a number: the optical depth of a path of one voxel's length, in whole units, so
// that the order of summation does not matter. The numbers are stored brick by brick; a brick has the 64 numbers of 4 × 4 × 4 voxels. There
// are also bits in the layout of grid/grid.glsl. On level 0, a voxel's bit is set if its sum overflowed 32 bits. On the levels above, the
// bit of a brick or block is set if it is not empty. Source: ours. Twin: reference::twin::media::Media.
#ifndef GRID_MEDIA_GLSL
#define GRID_MEDIA_GLSL
#include "grid/grid.glsl"

// Number of units per optical depth of 1; and the optical depth of a voxel whose sum overflowed 32 bits, behind which no light is left.
const float MEDIA_UNITS = 16777216.0;
const float MEDIA_FULL = 256.0;

uint media_at(uint size, uvec3 voxel) { return 64u * grid_word(size, 0u, voxel) + grid_bit(0u, voxel); }
#endif
