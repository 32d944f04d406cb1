#version 460
// Builds leaves: 8 × 8 × 1 voxels, one bit each, set if the voxel is shadowed. A block with lit and shadowed columns has a leaf. One thread
// per leaf. Source: Sintorn et al. 2014. Inputs: boundaries, ranges, values. Output: candidates, two words each. Twin:
// reference::twin::voxelized::leaf.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/find.glsl"

void main() {
    uint node = 64u * build_group() + gl_LocalInvocationIndex;
    if (node >= levels[0].candidates) {
        return;
    }
    uvec2 found = find_block(at, width * width, node);
    uint z = ranges[child_at + found.x].x + found.y, row = 8u * width;
    uint first = columns_at + 8u * (found.x / width) * row + 8u * (found.x % width);
    uvec2 bits = uvec2(0u);
    for (uint c = 0u; c < 64u; ++c) {
        uint shadowed = uint(z >= boundaries[first + (c >> 3) * row + (c & 7u)]);
        bits[c >> 5] |= shadowed << (c & 31u);
    }
    candidates[LEAF_WORDS * node] = bits.x;
    candidates[LEAF_WORDS * node + 1u] = bits.y;
}
