#version 460
// Copies the curves of a group of maps from the attachments of technique/avsm/raster_order.frag to the buffer that the look-up reads on
// every path. Inputs: the attachments, counts. Output: nodes.
// variants: ATTACHMENTS 2 4 8
#include "technique/avsm/attachments.glsl"
#include "technique/avsm/maps.glsl"
#include "maps/curve/node.glsl"
#include "maps/curve/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 1, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Counts { uint counts[]; };
// set 2: avsm_attachments
#define STORED(i) layout(set = 2, binding = i) uniform texture2D stored_##i;
EACH_ATTACHMENT(STORED)

#include "maps/curve/store.glsl"

void main() {
    uvec2 size = map_size();
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, size)) || tile_skipped(counts[group_tile()])) {
        return;
    }
    // The maps of the group are stacked vertically.
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy + uvec2(0u, gl_WorkGroupID.z * size.y));
    vec4 pairs[ATTACHMENTS];
#define UNPACK(i) pairs[i] = texelFetch(stored_##i, texel, 0);
    EACH_ATTACHMENT(UNPACK)
    Node curve[NODES];
    [[unroll]] for (int i = 0; i < NODES; i += 2) {
        curve[i] = Node(pairs[i / 2].x, pairs[i / 2].y);
        curve[i + 1] = Node(pairs[i / 2].z, pairs[i / 2].w);
    }
    store_curve(group_texel(group_map()), curve);
}
