#version 460
// Computes prefix sums of the blocks' weights, and their total. Source: none. Inputs and outputs: blocks, head. Invariant: as in
// technique/ism/sums.comp. Twin: reference::twin::ism::points.
layout(local_size_x = 128) in;
#include "technique/ism/sample.glsl"

shared uint part[2][BLOCK];

void main() {
    uint thread = gl_LocalInvocationIndex, before = 0u;
    for (uint first = 0u; first < block_count(); first += BLOCK) {
        uint i = first + thread, from = 0u;
        uint own = i < block_count() ? blocks[i] : 0u;
        part[from][thread] = own;
        barrier();
        for (uint step = 1u; step < BLOCK; step *= 2u) {
            part[1u - from][thread] = part[from][thread] + (thread >= step ? part[from][thread - step] : 0u);
            from = 1u - from;
            barrier();
        }
        if (i < block_count()) {
            blocks[i] = before + part[from][thread] - own;
        }
        before += part[from][BLOCK - 1u];
        barrier();
    }
    if (thread == 0u) {
        head.total = before;
    }
}
