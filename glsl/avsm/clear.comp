#version 460
// Empties every curve, for the interlock path. Output: nodes.
#include "avsm/node.glsl"
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 256) in;

layout(set = 0, binding = 0, scalar) writeonly buffer Nodes { Node nodes[]; };

layout(push_constant, scalar) uniform Push { uint count; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < count) {
        nodes[index] = Node(EMPTY, curve_unshadowed());
    }
}
