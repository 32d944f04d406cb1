#version 460
// Empties the curves of a map's tiles that have casters, for the interlock path. Input: counts. Output: nodes.
#include "avsm/node.glsl"
#include "avsm/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, scalar) writeonly buffer Nodes { Node nodes[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uvec2 size;
};

void main() {
    uvec2 texel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(texel, size)) || tile_skipped(counts[tile_place(map)])) {
        return;
    }
    // As in avsm/insert.frag.
    uint slot = PACKED == 1u ? 0u : map;
    uint first = ((slot * size.y + texel.y) * size.x + texel.x) * NODES;
    for (int i = 0; i < NODES; ++i) {
        nodes[first + i] = Node(EMPTY, curve_unshadowed());
    }
}
