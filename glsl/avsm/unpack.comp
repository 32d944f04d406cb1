#version 460
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_scalar_block_layout : require
// Moves the curves of a map out of the attachments of avsm/raster_order.frag into the buffer that the look-up reads on every path.
// Inputs: the attachments, counts. Output: nodes.
#include "avsm/attachments.glsl"
#include "avsm/node.glsl"
#include "avsm/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Counts { uint counts[]; };
#define STORED(i) layout(set = 1, binding = i) uniform texture2D stored_##i;
EACH_ATTACHMENT(STORED)

layout(push_constant, scalar) uniform Push { uint map; };

#include "avsm/store.glsl"

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(stored_0, 0);
    if (any(greaterThanEqual(texel, size)) || tile_skipped(counts[tile_place(map)])) {
        return;
    }
    uint index = (map * uint(size.y) + uint(texel.y)) * uint(size.x) + uint(texel.x);
    vec4 pairs[ATTACHMENTS];
#define UNPACK(i) pairs[i] = texelFetch(stored_##i, texel, 0);
    EACH_ATTACHMENT(UNPACK)
    Node curve[NODES];
    [[unroll]] for (int i = 0; i < NODES; i += 2) {
        curve[i] = Node(pairs[i / 2].x, pairs[i / 2].y);
        curve[i + 1] = Node(pairs[i / 2].z, pairs[i / 2].w);
    }
    store_curve(index, curve);
}
