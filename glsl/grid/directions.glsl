// The directions of strands in the voxels of a grid: a symmetric matrix per voxel, the sum over strands of extinction times the outer
// product of the direction with itself. Voxels are in the order of grid/media.glsl, numbers in the order xx, yy, zz, xy, yz, zx. The trace
// is the strands' extinction. Numbers are whole, so that the order of sums does not matter, and have two bits fewer than those of media:
// unless a voxel is full, none passes 31 bits. Source: ours. Twin: reference::twin::soft::Directions.
#ifndef GRID_DIRECTIONS_GLSL
#define GRID_DIRECTIONS_GLSL

const float DIRECTION_UNITS = 4194304.0;

// A strand's extinction across its axis, divided by its mean over all directions: 4 / π.
const float ACROSS = 1.27323954;

// Where E[|sin|] is taken to lie, from E[sin²] (0) to its root (1), if the strands of a voxel do not run in one
// direction.
const float SPREAD_SHARE = 0.75;

// A voxel's extinction towards a direction; `sum`: its mean over all directions. `diagonal` and `beside` are the matrix M of its strands,
// which gives E[sin²] of their angle to that direction. E[|sin|], which is wanted, lies between E[sin²] and its root, and is the root where
// all strands run one way. There |E[cos · d across the direction]|², d being a strand's direction, is as large as Cauchy and Schwarz allow,
// E[cos²] E[sin²]. Elsewhere `one_way` is its share of that.
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
