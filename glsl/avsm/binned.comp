#version 460
// Builds the curves of one tile of 8×8 texels: sorts the tile's casters, then each thread inserts their segments into
// its texel's curve and writes it once. No lists, no blending, no interlock.
// Inputs: maps, casters, parts, entries. Outputs: nodes of tiles that have casters.
// Invariant: the result depends only on the casters, not on the order in which they were binned.
// Source: ours. Twin: reference::twin::avsm::curve, with the keys of reference::twin::bins.

// LANES 0: the tile's casters stand in shared memory, some at a time. LANES 1: in the lanes of subgroups (bins/batch.glsl).
// variants: LANES 0 1
#define BINS_ENTRIES_WRITTEN
#define BATCH_SOURCE(view, entry) view_caster(view, casters[sort_entry(tile.first, tile.count, (entry) - tile.first).y])
#include "avsm/curve.glsl"
#include "bins/area.glsl"
#include "bins/part.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

// What the workgroup builds.
TilePart tile;

#include "avsm/store.glsl"
#include "bins/sort.glsl"

const uint THREADS = TILE_THREADS;
#include "bins/batch.glsl"

void main() {
    if (!listed_part(tile)) {
        return;
    }
    View view = part_view(tile);
    sort_tile(tile.first, tile.count);
    uvec2 texel = part_corner(view, tile) + gl_LocalInvocationID.xy;
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction);
    curve_clear();
    for (uint begin = 0u; begin < tile.count; begin += batch_size()) {
        uint filled = min(batch_size(), tile.count - begin);
        fetch_batch(view, tile.first + begin, filled);
        // Each thread looks for its next hit before any inserts: the threads of a subgroup then insert together, as
        // often as the busiest of them has hits, and not once for every caster that one of them meets.
#if LANES == 1
        // All look at one caster alike, and keep which they hit; these few are fetched again.
        uvec2 hits = uvec2(0u);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            bool hit = texel_part(view, ray, ray_length, batch_caster(i), MAX_OPTICAL_DEPTH, z, optical_depth);
            hits |= uvec2(i < 32u, i >= 32u) * (uint(hit) << i % 32u);
        }
        while (hits != uvec2(0u)) {
            uint i = hits.x != 0u ? uint(findLSB(hits.x)) : 32u + uint(findLSB(hits.y));
            hits = hits.x != 0u ? uvec2(hits.x & (hits.x - 1u), hits.y) : uvec2(0u, hits.y & (hits.y - 1u));
            vec2 z;
            float optical_depth;
            Caster caster = BATCH_SOURCE(view, tile.first + begin + i);
            if (texel_part(view, ray, ray_length, caster, MAX_OPTICAL_DEPTH, z, optical_depth)) {
                curve_insert(view_depth(view, z.x), view_depth(view, z.y), optical_depth);
            }
        }
#else
        uint next = 0u;
        while (next < filled) {
            vec2 z;
            float optical_depth = 0.0;
            bool hit = false;
            while (!hit && next < filled) {
                hit = texel_part(view, ray, ray_length, batch_caster(next), MAX_OPTICAL_DEPTH, z, optical_depth);
                ++next;
            }
            if (hit) {
                curve_insert(view_depth(view, z.x), view_depth(view, z.y), optical_depth);
            }
        }
#endif
    }
    end_part(tile);
    if (any(greaterThanEqual(texel, uvec2(view.width, view.height)))) {
        return;
    }
    curve_reduce();
    store_curve(part_texel(view, tile, texel));
}
