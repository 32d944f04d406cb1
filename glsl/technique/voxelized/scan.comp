#version 460
// Computes prefix sums within each block of 1,024 values, and the block's total. Source: Blelloch 1990. Input and output: values, sums.
// Twin: reference::twin::voxelized, which adds in a loop.
layout(local_size_x = 128) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/scan.glsl"

uint value_of(uint i) { return i < scan_at + scan_count ? values[i] : 0u; }

void main() {
    if (build_group() < (scan_count + SCANNED - 1u) / SCANNED) {
        uint first = scan_at + SCANNED * build_group();
        SCAN_BLOCK(first, value_of)
    }
}
