#version 460
// Where the corners of each triangle lie among the columns of a light's cube: in 256ths of a voxel across, whole numbers, so
// that whether a column meets a triangle has one answer on every device. Source: ours. Inputs: triangles, sides, trees. Output:
// projected. Twin: reference::twin::voxelized::project.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/projected.glsl"

void main() {
    uint i = 64u * build_group() + gl_LocalInvocationIndex;
    if (i >= triangle_count) {
        return;
    }
    Tree tree = trees[light];
    for (uint c = 0u; c < 3u; ++c) {
        vec3 offset = triangles[i].corners[c] - tree.origin;
        // Without this a product might be fused with a sum, and the twin's are not.
        precise float x = offset.x * tree.right.x + offset.y * tree.right.y + offset.z * tree.right.z;
        precise float y = offset.x * tree.up.x + offset.y * tree.up.y + offset.z * tree.up.z;
        precise float z = offset.x * tree.forward.x + offset.y * tree.forward.y + offset.z * tree.forward.z;
        projected[PROJECTED_WORDS * i + 2u * c] = int(floor(x * SUB_VOXELS + 0.5));
        projected[PROJECTED_WORDS * i + 2u * c + 1u] = int(floor(y * SUB_VOXELS + 0.5));
        projected[PROJECTED_WORDS * i + 6u + c] = floatBitsToInt(z);
    }
    projected[PROJECTED_WORDS * i + 9u] = int(sides[i]);
}
