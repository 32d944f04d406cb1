#version 460
// Counts, before each candidate, the nodes that are the first of their kind: this numbers the kept nodes. Input: slots,
// table. Outputs: values from rank_at on, sums. Twin: reference::twin::voxelized::merge.
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
