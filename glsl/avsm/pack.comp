#version 460
// Packs the curves of a group of maps, which avsm/insert.frag built in full. Inputs: full. Output: nodes.
// Invariant: each curve is rounded once, after all insertions.
#include "avsm/maps.glsl"
#include "avsm/node.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 1, binding = 0, scalar) readonly buffer Full { Node full[]; };
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

#include "avsm/store.glsl"

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, map_size()))) {
        return;
    }
    Node curve[NODES];
    uint first = group_texel(gl_WorkGroupID.z) * NODES;
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        curve[i] = full[first + i];
    }
    store_curve(group_texel(group_map()), curve);
}
