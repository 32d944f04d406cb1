// The directions of strands in the voxels of a grid: a symmetric matrix per voxel, the sum over strands of extinction times the outer
// product of the direction with itself, voxels in the order of grid/media.glsl, numbers in the order xx, yy, zz, xy, yz, zx. Its trace is
// the strands' extinction. In whole units, so that the order of sums does not matter, two bits fewer than those of media: where a voxel is
// not full, no number passes 31 bits. Source: ours. Twin: reference::twin::soft::Directions.
#ifndef GRID_DIRECTIONS_GLSL
#define GRID_DIRECTIONS_GLSL

const float DIRECTION_UNITS = 4194304.0;

// Extinction of a strand across its axis, over its mean over all directions: 4 / π.
const float ACROSS = 1.27323954;

// Between E[sin²] and its root, where the strands of a voxel do not run in one direction.
const float SPREAD_SHARE = 0.75;

// What a voxel takes of a way towards there that takes so much on average, by the matrix M of its strands. E[sin²] of their angle to the way
// follows from it. E[|sin|], which is asked, lies between that and its root: at the root where all run one way, and there |E[cos · d across
// the way]|² is all that Cauchy and Schwarz leave it, E[cos²] E[sin²], of which it is a share else.
float directed(float sum, vec3 diagonal, vec3 beside, vec3 towards) {
    float strands = diagonal.x + diagonal.y + diagonal.z;
    vec3 seen = diagonal * towards + beside * towards.yzx + beside.zxy * towards.zxy;
    float along = dot(seen, towards), across = max(strands - along, 0.0);
    vec3 aside = seen - along * towards;
    float one_way = clamp(dot(aside, aside) / max(along * across, 1e-30), 0.0, 1.0);
    float root = sqrt(max(strands * across, 0.0));
    float taken = mix(min(across, strands), min(root, strands), mix(SPREAD_SHARE, 1.0, one_way));
    return max(sum - strands, 0.0) + ACROSS * taken;
}
#endif
