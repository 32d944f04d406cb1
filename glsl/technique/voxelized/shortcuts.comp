#version 460
// Builds a table with the tree's node at each cell of a coarse grid, so that look-ups can skip the first levels. One thread per cell.
// Source: ours. Inputs: trees, data. Output: data from the tree's shortcuts on. Twin:
// reference::twin::voxelized::shortcuts.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/walk.glsl"

void main() {
    uint levels = trees[light].levels, bits = shortcut_bits(levels);
    uint cell = 64u * build_group() + gl_LocalInvocationIndex;
    // If not all words fit, there is no tree to descend.
    if (cell >= 1u << 3u * bits || failed != 0u || words >= data_capacity) {
        return;
    }
    uvec3 voxel = (uvec3(cell, cell >> bits, cell >> 2u * bits) & ((1u << bits) - 1u)) << (levels + 1u - bits);
    Walk walk = walk_from_root(light);
    while (walk.kind == INTERSECTED && walk.level > levels - 1u - bits) {
        walk_down(light, voxel, walk);
    }
    data[trees[light].shortcuts + cell] = walk.kind | (walk.kind == INTERSECTED ? walk.node << 2 : 0u);
}
