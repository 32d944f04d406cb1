// Directions of strands in the voxels of a grid, or normals of sheets: a symmetric matrix per voxel, the sum over strands of extinction times
// the outer product of the direction with itself. Voxels are in the order of grid/media.glsl, coefficients in the order xx, yy, zz, xy, yz, zx. The trace is
// the strands' extinction. The coefficients are integers, so that the order of summation does not matter. They have two bits fewer than the
// numbers of media, so none of a voxel's coefficients needs more than 31 bits unless its sum of media overflowed. Source: ours. Twin:
// reference::twin::soft::Directions.
#ifndef GRID_DIRECTIONS_GLSL
#define GRID_DIRECTIONS_GLSL

const float DIRECTION_UNITS = 4194304.0;

// Ratio of a strand's extinction across its axis to its mean over all directions: 4 / π.
const float ACROSS = 1.27323954;

// Ratio of a sheet's extinction along its normal to its mean over all directions.
const float FACED = 2.0;

// Interpolation weight for a voxel whose strands are not parallel: E[|sin|] is estimated between E[sin²] (0) and the square root of E[sin²]
// (1).
const float SPREAD_SHARE = 0.75;

// True: the matrices are of sheets, and strands, if there are any, count with their mean over all directions. A sheet is widest along its
// normal, where a strand is narrowest.
CONSTANT(bool, FACING, false)

// A voxel's extinction in the direction `towards`. `sum`: its mean over all directions. `diagonal` and `beside`: the matrix of the voxel's
// strands. Let a be the angle between a strand and `towards`. The matrix gives E[sin² a], but the extinction follows from E[|sin a|]. That
// value lies between E[sin² a] and its square root, and equals the square root if all strands are parallel. `one_way` measures how parallel
// they are. Let d be the component of a strand's direction across `towards`. Then |E[d cos a]|² is at most E[cos² a] E[sin² a] (Cauchy and
// Schwarz), with equality if all strands are parallel. `one_way` is the ratio of the two.
float directed(float sum, vec3 diagonal, vec3 beside, vec3 towards) {
    float strands = diagonal.x + diagonal.y + diagonal.z;
    vec3 seen = diagonal * towards + beside * towards.yzx + beside.zxy * towards.zxy;
    float along = dot(seen, towards), across = max(strands - along, 0.0);
    vec3 aside = seen - along * towards;
    float one_way = clamp(dot(aside, aside) / max(along * across, 1e-30), 0.0, 1.0);
    float square = FACING ? max(along, 0.0) : across, root = sqrt(max(strands * square, 0.0));
    float taken = mix(min(square, strands), min(root, strands), mix(SPREAD_SHARE, 1.0, one_way));
    return max(sum - strands, 0.0) + (FACING ? FACED : ACROSS) * taken;
}
#endif
