#version 460
// Builds the curves of one tile of 8×8 texels: sorts the tile's casters, then each thread inserts their segments into
// its texel's curve and writes it once. No lists, no blending, no interlock.
// Inputs: map, casters, parts, entries. Outputs: nodes of tiles that have casters.
// Invariant: the result depends only on the casters, not on the order in which they were binned.
#include "avsm/curve.glsl"
#include "bins/totals.glsl"
#include "list/texel_segment.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Parts { TilePart parts[]; };
layout(set = 1, binding = 4, scalar) coherent buffer Entries { uvec2 entries[]; };
layout(set = 1, binding = 3, scalar) readonly buffer Totals { BinTotals totals[]; };
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

layout(push_constant, scalar) uniform Push { uint map; };

#include "bins/part.glsl"
#include "avsm/store.glsl"
#include "bins/sort.glsl"

// Some of the sorted casters, fetched together.
const uint BATCH = 256u;
shared Caster batch[BATCH];

void main() {
    TilePart part;
    if (!listed_part(map, part)) {
        return;
    }
    View view = maps[map].volume;
    uvec2 tiles = (uvec2(view.width, view.height) + 7u) / 8u;
    uint first = part.first, count = part.count;
    sort_tile(first, count);
    uvec2 texel = uvec2(part.tile % tiles.x, part.tile / tiles.x) * 8u + gl_LocalInvocationID.xy;
    curve_clear();
    for (uint begin = 0u; begin < count; begin += BATCH) {
        uint filled = min(BATCH, count - begin);
        for (uint i = gl_LocalInvocationIndex; i < filled; i += TILE_THREADS) {
            batch[i] = casters[sort_entry(first, count, begin + i).y];
        }
        barrier();
        // Each thread looks for its next hit before any inserts: the threads of a subgroup then insert together, as
        // often as the busiest of them has hits, and not once for every caster that one of them meets.
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
    store_curve((map * view.height + texel.y) * view.width + texel.x);
}
