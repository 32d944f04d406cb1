#version 460
// Builds the curves of one tile of 8×8 texels: sorts the tile's particles, then each thread inserts their segments into
// its texel's curve and writes it once. No lists, no blending, no interlock.
// Inputs: light, particles, counts, offsets, entries. Outputs: nodes of tiles that have particles.
// Invariant: the result depends only on the particles, not on the order in which they were binned.
#include "avsm/curve.glsl"
#include "list/texel_segment.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Offsets { uint offsets[]; };
layout(set = 1, binding = 4, scalar) coherent buffer Entries { uvec2 entries[]; };
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { Node nodes[]; };

#include "bins/sort.glsl"

// Some of the sorted particles, fetched together.
const uint BATCH = 256u;
shared Particle batch[BATCH];

void main() {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint first = offsets[tile], count = counts[tile];
    if (count == 0u) {
        return;  // the look-up does not read this tile
    }
    sort_tile(first, count);
    View view = lights[0].volume;
    uvec2 texel = gl_GlobalInvocationID.xy;
    curve_clear();
    for (uint begin = 0u; begin < count; begin += BATCH) {
        uint filled = min(BATCH, count - begin);
        for (uint i = gl_LocalInvocationIndex; i < filled; i += TILE_THREADS) {
            batch[i] = particles[sort_entry(first, count, begin + i).y];
        }
        barrier();
        // Each thread looks for its next hit before any inserts: the threads of a subgroup then insert together, as
        // often as the busiest of them has hits, and not once for every particle that one of them meets.
        uint next = 0u;
        while (next < filled) {
            vec2 depth;
            float optical_depth = 0.0;
            bool hit = false;
            while (!hit && next < filled) {
                hit = texel_segment(view, texel, batch[next], depth, optical_depth);
                ++next;
            }
            if (hit) {
                curve_insert(depth.x, depth.y, optical_depth);
            }
        }
        barrier();
    }
    if (any(greaterThanEqual(texel, uvec2(view.width, view.height)))) {
        return;
    }
    curve_reduce();
    uint at = (texel.y * view.width + texel.x) * NODES;
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        nodes[at + i] = curve_node(i);
    }
}
