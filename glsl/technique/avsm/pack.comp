#version 460
// Reorders the curves that technique/avsm/insert.frag built for a group of maps, so that each curve's nodes are contiguous. Works in place,
// or packs the curves into another buffer. Inputs: built, counts. In and out: nodes. Invariant: each curve is rounded once, after all
// insertions. In place, nodes move only among eight neighbouring texels.
#include "technique/avsm/interleaved_layout.glsl"
#include "technique/avsm/maps.glsl"
#include "maps/curve/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// With PACKED: the unpacked curves of the maps drawn at once.
layout(set = 1, binding = 0, scalar) readonly buffer Built { uvec2 built[]; };
layout(set = 2, binding = 0, scalar) buffer Nodes { uvec2 nodes[]; };
layout(set = 2, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

#include "maps/curve/store.glsl"

Node stored_node(uint i) {
    uvec2 words = PACKED ? built[i] : nodes[i];
    return Node(uintBitsToFloat(words.x), uintBitsToFloat(words.y));
}

void main() {
    if (tile_skipped(counts[group_tile()])) {
        return;
    }
    uvec2 size = map_size();
    bool within = all(lessThan(gl_GlobalInvocationID.xy, size));
    Node curve[NODES];
    uint row = group_texel(PACKED ? gl_WorkGroupID.z : group_map()) - gl_GlobalInvocationID.x;
    [[unroll]] for (int i = 0; i < NODES / 2 && within; ++i) {
        uint place = 2u * pair_place(row, gl_GlobalInvocationID.x, size.x, i);
        curve[2 * i] = stored_node(place);
        curve[2 * i + 1] = stored_node(place + 1u);
    }
    // All eight texels are read before any is written.
    memoryBarrierBuffer();
    barrier();
    if (within) {
        store_curve(group_texel(group_map()), curve);
    }
}
