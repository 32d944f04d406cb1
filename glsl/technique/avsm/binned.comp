#version 460
// Builds the curves of one tile of 8×8 texels: sorts the tile's casters, then each thread inserts their segments into
// its texel's curve, which it writes once. No lists, no blending, no interlock. Inputs: maps, casters, parts, entries.
// Outputs: nodes of tiles that have casters. Invariant: the result depends only on the casters, not on the order in
// which they were binned. Source: ours. Twin: reference::twin::avsm::curve, with the keys of reference::twin::bins.

// LANES 0: shared memory holds the tile's casters, some at a time. LANES 1: the lanes of each subgroup hold them (maps/bins/batch.glsl),
// and the subgroup leaves out casters that cannot meet its texels.
// variants: LANES 0 1
#define BINS_ENTRIES_WRITTEN
#define BATCH_SOURCE(view, entry) sorted_caster(view, entry)
#include "maps/curve/curve.glsl"
#include "maps/bins/area.glsl"
#include "maps/bins/part.glsl"
#include "maps/bins/sort.glsl"

// All along x: where full subgroups are asked for, the size along x must be a multiple of theirs.
layout(local_size_x = TILE_THREADS) in;

layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

// The workgroup's task.
TilePart tile;

#include "maps/curve/store.glsl"

Caster sorted_caster(View view, uint entry) {
    return view_caster(view, casters[sort_entry(tile.first, tile.count, entry - tile.first).y]);
}

const uint THREADS = TILE_THREADS;
#include "maps/bins/batch.glsl"

// Inserts a caster's segment, as texel_part returned it. Casters come in the order of the tile, which is nearly the order along each
// texel's ray. Where the two orders differ, the transmittance behind the casters is right, but the light may be taken at the wrong one of
// two strands.
void insert_part(View view, Ray ray, Caster caster, vec2 z, float optical_depth) {
    optical_depth = area_seen(view, ray, caster, MAX_OPTICAL_DEPTH, optical_depth);
    curve_insert(view_depth(view, z.x), view_depth(view, z.y), optical_depth);
}

#if LANES == 1
// How many casters are tested, with a bit each, before those that are hit are inserted.
const uint AT_ONCE = 64u;

// The texel of a thread, so that those of a subgroup of any size are a square or half of one.
uvec2 texel_in_tile() {
    uint i = gl_LocalInvocationIndex;
    return uvec2(i & 1u | i >> 1u & 2u | i >> 2u & 4u, i >> 1u & 1u | i >> 2u & 2u | i >> 3u & 4u);
}

// Returns the lowest bit that is set, and clears it.
uint take_first(inout uvec2 bits) {
    bool in_x = bits.x != 0u;
    uint first = in_x ? uint(findLSB(bits.x)) : 32u + uint(findLSB(bits.y));
    bits = in_x ? uvec2(bits.x & (bits.x - 1u), bits.y) : uvec2(0u, bits.y & (bits.y - 1u));
    return first;
}

// Which of AT_ONCE casters, from the tile's `begin` on, the texel meets, a bit each. Each lane tests whether its own
// caster may meet the subgroup's texels, `first` to `last`; all lanes then look at those casters that may.
uvec2 hits_of(View view, Ray ray, float ray_length, uvec2 first, uvec2 last, uint begin, uint filled) {
    uvec2 hits = uvec2(0u);
    for (uint some = 0u; some < filled; some += batch_size()) {
        uint count = min(filled - some, batch_size());
        fetch_batch(view, tile.first + begin + some, count);
        vec2 low, high;
        bool reaches = texel_bounds(view, lane_caster, low, high) && all(lessThanEqual(low, vec2(last))) &&
                       all(greaterThanEqual(high, vec2(first)));
        // In perspective, a texel's share of a strand that points at the light is not bounded by where its ends are.
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
        // The few that are hit are fetched again.
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

// Each thread looks for its next hit before any thread inserts. Then the threads of a subgroup insert together. They do so as often as the
// busiest thread has hits, and not once for every caster that any of them meets.
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
