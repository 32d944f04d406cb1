#version 460
// Clears the curves of tiles that have casters, for the interlock path. Inputs: maps, counts. Output: nodes.
#include "technique/avsm/interleaved_layout.glsl"
#include "technique/avsm/maps.glsl"
#include "maps/curve/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: avsm_full
layout(set = 1, binding = 0, scalar) writeonly buffer Nodes { Node nodes[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, map_size())) || tile_skipped(counts[group_tile()])) {
        return;
    }
    // As in technique/avsm/insert.frag.
    uint row = group_texel(PACKED ? gl_WorkGroupID.z : group_map()) - gl_GlobalInvocationID.x;
    for (int i = 0; i < NODES / 2; ++i) {
        uint place = 2u * pair_place(row, gl_GlobalInvocationID.x, map_size().x, i);
        nodes[place] = Node(EMPTY, curve_unshadowed());
        nodes[place + 1u] = Node(EMPTY, curve_unshadowed());
    }
}
