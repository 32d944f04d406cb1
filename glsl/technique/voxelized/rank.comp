#version 460
// Counts, for each candidate, how many candidates before it are the first of a set of equal nodes. These counts are the indices of the kept
// nodes. Input: slots, table. Outputs: values from rank_at on, sums. Twin: reference::twin::voxelized::merge.
layout(local_size_x = 128) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/merge.glsl"
#include "technique/voxelized/scan.glsl"

uint value_of(uint i) {
    uint candidate = i - rank_at;
    return uint(candidate < levels[level].candidates && is_first(candidate));
}

void main() {
    if (build_group() < (levels[level].candidates + SCANNED - 1u) / SCANNED) {
        uint first = rank_at + SCANNED * build_group();
        SCAN_BLOCK(first, value_of)
    }
}
