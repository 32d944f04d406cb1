#version 460
#extension GL_EXT_scalar_block_layout : require
// Packs the curves of a map, which avsm/insert.frag built in full. Inputs: full. Output: nodes.
// Invariant: each curve is rounded once, after all insertions.
#include "avsm/node.glsl"

layout(local_size_x = 256) in;

layout(set = 0, binding = 0, scalar) readonly buffer Full { Node full[]; };
layout(set = 1, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uint count;  // texels of a map
};

#include "avsm/store.glsl"

void main() {
    uint texel = gl_GlobalInvocationID.x;
    if (texel >= count) {
        return;
    }
    Node curve[NODES];
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        curve[i] = full[texel * NODES + i];
    }
    store_curve(map * count + texel, curve);
}
