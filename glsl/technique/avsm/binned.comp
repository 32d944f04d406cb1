#version 460
// Builds the curves of one tile of 8×8 texels. The workgroup sorts the tile's casters; each thread then inserts their segments into its
// texel's curve and writes the curve once. No lists, no blending, no interlock. Inputs: maps, casters, parts, entries. Outputs: nodes of
// tiles that have casters. Invariant: the result depends only on the casters, not on the order in which they were binned. Source: ours.
// Twin: reference::twin::avsm::curve, with the keys of reference::twin::bins.

// LANES 0: shared memory holds a batch of the tile's casters. LANES 1: the lanes of each subgroup hold the batch (maps/bins/batch.glsl),
// and the subgroup skips casters that cannot cover its texels.
// variants: LANES 0 1
#define BINS_ENTRIES_WRITTEN
#define BATCH_SOURCE(view, entry) sorted_caster(view, entry)
#include "maps/curve/curve.glsl"
#include "maps/bins/area.glsl"
#include "maps/bins/part.glsl"
#include "maps/bins/sort.glsl"

// One-dimensional: if full subgroups are required, the size along x must be a multiple of the subgroup size.
layout(local_size_x = TILE_THREADS) in;

layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

// The part that this workgroup builds.
TilePart tile;

#include "maps/curve/store.glsl"

Caster sorted_caster(View view, uint entry) {
    return view_caster(view, casters[sort_entry(tile.first, tile.count, entry - tile.first).y]);
}

const uint THREADS = TILE_THREADS;
#include "maps/bins/batch.glsl"

// Inserts a caster's segment, as returned by texel_part. Casters arrive in the tile's sort order, which is nearly the order along each
// texel's ray. Where the two orders differ, the transmittance behind the casters is still right, but the light may be absorbed at the wrong
// one of two strands.
void insert_part(View view, Ray ray, Caster caster, vec2 z, float optical_depth) {
    optical_depth = area_seen(view, ray, caster, MAX_OPTICAL_DEPTH, optical_depth);
    curve_insert(view_depth(view, z.x), view_depth(view, z.y), optical_depth);
}

#if LANES == 1
// Number of casters that are tested, one bit each, before the hits among them are inserted.
const uint AT_ONCE = 64u;

// Returns the thread's texel, in Morton order: the texels of a subgroup of any size form a square or half a square.
uvec2 texel_in_tile() {
    uint i = gl_LocalInvocationIndex;
    return uvec2(i & 1u | i >> 1u & 2u | i >> 2u & 4u, i >> 1u & 1u | i >> 2u & 2u | i >> 3u & 4u);
}

// Returns the index of the lowest set bit, and clears that bit.
uint take_first(inout uvec2 bits) {
    bool in_x = bits.x != 0u;
    uint first = in_x ? uint(findLSB(bits.x)) : 32u + uint(findLSB(bits.y));
    bits = in_x ? uvec2(bits.x & (bits.x - 1u), bits.y) : uvec2(0u, bits.y & (bits.y - 1u));
    return first;
}

// Returns one bit per caster, for AT_ONCE casters from the tile's `begin` on: whether the texel's ray hits it. Each lane tests whether its
// own caster may cover the subgroup's texels, `first` to `last`; all lanes then test the casters that may.
uvec2 hits_of(View view, Ray ray, float ray_length, uvec2 first, uvec2 last, uint begin, uint filled) {
    uvec2 hits = uvec2(0u);
    for (uint some = 0u; some < filled; some += batch_size()) {
        uint count = min(filled - some, batch_size());
        fetch_batch(view, tile.first + begin + some, count);
        vec2 low, high;
        bool reaches = texel_bounds(view, lane_caster, low, high) && all(lessThanEqual(low, vec2(last))) &&
                       all(greaterThanEqual(high, vec2(first)));
        // In perspective, the projected ends of a strand that points at the light do not bound the texels that it covers.
        bool unbounded = AREA && view.projection != VIEW_PARALLEL && caster_is_strand(lane_caster);
        bool meets = gl_SubgroupInvocationID < count && (reaches || unbounded);
        uvec2 met = subgroupBallot(meets).xy;
        while (met != uvec2(0u)) {
            uint i = take_first(met);
            vec2 z;
            float optical_depth;
            bool hit = texel_part(view, ray, ray_length, batch_caster(i), MAX_OPTICAL_DEPTH, z, optical_depth);
            i += some;
            hits |= uvec2(i < 32u, i >= 32u) * (uint(hit) << i % 32u);
        }
    }
    return hits;
}

void insert_tile(View view, uvec2 texel, Ray ray, float ray_length) {
    uvec2 first = texel, last = texel;
    for (uint i = 0u; i < gl_SubgroupSize; ++i) {
        uvec2 other = subgroupBroadcast(texel, i);
        first = min(first, other);
        last = max(last, other);
    }
    for (uint begin = 0u; begin < tile.count; begin += AT_ONCE) {
        uvec2 hits = hits_of(view, ray, ray_length, first, last, begin, min(AT_ONCE, tile.count - begin));
        // Fetches the few casters that are hit again.
        while (hits != uvec2(0u)) {
            Caster caster = sorted_caster(view, tile.first + begin + take_first(hits));
            vec2 z;
            float optical_depth;
            if (texel_part(view, ray, ray_length, caster, MAX_OPTICAL_DEPTH, z, optical_depth)) {
                insert_part(view, ray, caster, z, optical_depth);
            }
        }
    }
}
#else
uvec2 texel_in_tile() { return uvec2(gl_LocalInvocationIndex % 8u, gl_LocalInvocationIndex / 8u); }

// Each thread finds its next hit before any thread inserts. The threads of a subgroup then insert together: the number of insertions is the
// hit count of the busiest thread, not the number of casters hit by at least one thread.
void insert_tile(View view, uvec2 texel, Ray ray, float ray_length) {
    for (uint begin = 0u; begin < tile.count; begin += batch_size()) {
        uint filled = min(batch_size(), tile.count - begin);
        fetch_batch(view, tile.first + begin, filled);
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
                insert_part(view, ray, batch_caster(next - 1u), z, optical_depth);
            }
        }
    }
}
#endif

void main() {
    if (!listed_part(tile)) {
        return;
    }
    View view = part_view(tile);
    sort_tile(tile.first, tile.count);
    uvec2 texel = part_corner(view, tile) + texel_in_tile();
    Ray ray = view_texel_ray(view, texel);
    curve_clear();
    area_clear();
    insert_tile(view, texel, ray, length(ray.direction));
    end_part(tile);
    if (any(greaterThanEqual(texel, uvec2(view.width, view.height)))) {
        return;
    }
    curve_reduce();
    store_curve(part_texel(view, tile, texel));
}
