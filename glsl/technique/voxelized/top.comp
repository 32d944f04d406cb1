#version 460
// Copies a tile's topmost nodes, which are as wide as the tile, to where the levels above look for them. One workgroup. Source: ours.
// Inputs: ranges and slots of the tile's top level. Outputs: ranges from child_at on, slots from child_slots_at on. `child_stride`:
// capacity, in nodes. Twin: reference::twin::voxelized, which has no tiles.
layout(local_size_x = 16) in;
#include "technique/voxelized/build.glsl"

void main() {
    uvec2 range = ranges[at];
    uint nodes = min(node_range(range, level_side(level)).y, child_stride);
    if (gl_LocalInvocationIndex == 0u) {
        ranges[child_at + tile] = range;
        values[child_at + tile] = 0u;
    }
    for (uint n = gl_LocalInvocationIndex; n < nodes; n += 16u) {
        slots[child_slots_at + tile * child_stride + n] = slots[slots_at + n];
    }
}
