// How strands run in the voxels of a grid: of what strands take in a voxel, times their direction, twice, a matrix of six numbers a voxel in
// the order of grid/media.glsl: xx, yy, zz, xy, yz, zx; the first three together are what strands take. In whole units, so that the order of sums
// does not matter, two bits fewer than those of media: where a voxel is not full, no number passes 31 bits. Source: ours.
// Twin: reference::twin::soft::Directions.
#ifndef GRID_DIRECTIONS_GLSL
#define GRID_DIRECTIONS_GLSL

const float DIRECTION_UNITS = 4194304.0;

// What a strand takes across, of what it takes on average over all directions.
const float ACROSS = 1.27323954;

// What a voxel takes of a way towards there that takes so much on average, by the matrix of its strands: E[sin²] of their angle to the
// way follows from it, and its root is at most 4 % more than E[|sin|].
float directed(float sum, vec3 diagonal, vec3 beside, vec3 towards) {
    float strands = diagonal.x + diagonal.y + diagonal.z;
    float along = dot(diagonal, towards * towards) + 2.0 * dot(beside, towards * towards.yzx);
    float across = sqrt(max(strands * (strands - along), 0.0));
    return max(sum - strands, 0.0) + ACROSS * min(across, strands);
}
#endif
