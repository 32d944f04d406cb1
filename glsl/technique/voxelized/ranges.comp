#version 460
// Computes the ranges and values of the next three levels from the ranges of one level's blocks of columns. A block of these levels
// consists of 2 × 2, 4 × 4 and 8 × 8 blocks of the first level. A range is the least exit and the greatest entry among a block's columns. A
// value is the number of a block's nodes that need children. Source: ours. Inputs: ranges of one level. Outputs: ranges and values of the
// next three levels. Twin: reference::twin::voxelized::Ranges.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"

shared uvec2 cells[64];

void main() {
    uint thread = gl_LocalInvocationIndex, groups = (width + 7u) / 8u, group = build_group();
    if (group >= groups * groups) {
        return;
    }
    uvec2 cell = uvec2(thread & 7u, thread >> 3), group_at = uvec2(group % groups, group / groups);
    uvec2 from = 8u * group_at + cell;
    bool there = all(lessThan(from, uvec2(width)));
    cells[thread] = there ? ranges[at + from.y * width + from.x] : uvec2(0xffffffffu, 0u);
    uint next = at + width * width;
    for (uint step = 1u; step <= 3u && (width >> step) > 0u; ++step) {
        uint stride = 1u << (step - 1u), across = width >> step;
        barrier();
        uvec2 to = (8u * group_at >> step) + (cell >> step);
        bool mine = all(equal(cell & ((1u << step) - 1u), uvec2(0u))) && all(lessThan(to, uvec2(across)));
        if (mine) {
            uvec2 a = cells[thread], b = cells[thread + stride], c = cells[thread + 8u * stride];
            uvec2 d = cells[thread + 9u * stride];
            uvec2 range = uvec2(min(min(a.x, b.x), min(c.x, d.x)), max(max(a.y, b.y), max(c.y, d.y)));
            // No other thread reads this cell in this step.
            cells[thread] = range;
            ranges[next + to.y * across + to.x] = range;
            values[next + to.y * across + to.x] = node_range(range, level_side(level + step)).y;
        }
        next += across * across;
    }
}
