#version 460
// Counts the casters of each tile of each map. A caster that touches no tile, because it is outside the light's volume or in the dark
// behind the meshes, is culled: it is neither drawn nor binned. Inputs: maps, casters, horizon. Outputs: counts, cleared beforehand; met,
// which may still contain marks of older builds.

// TALLY 0: each caster adds to the counts of its tiles. TALLY 1: a workgroup first counts the tiles of all its casters in shared memory.
// That is for maps with few tiles and very many casters, whose atomics would contend for the counts.
// variants: TALLY 0 1
#include "maps/bins/set.glsl"
#include "maps/bins/tiles.glsl"
#include "maps/bins/tally.glsl"

BINS_COUNTS(buffer)
BINS_MET(buffer)
BINS_HORIZON(readonly buffer)

void main() {
    uint map = gl_WorkGroupID.z, lane = tally_lane();
    View view = maps[map].caster_view;
    uvec2 tiles = tile_counts(view);
    uint first_tile = map * tiles.x * tiles.y;
    tally_clear(tiles);
    for (uint turn = 0u; turn < TALLY_TURNS; ++turn) {
        uint index = tally_caster(turn);
        uvec2 low, high;
        if (index >= caster_count || !caster_tiles(view, casters[index], low, high)) {
            continue;
        }
        Caster caster = casters[index];
        uvec2 size = high - low + 1u;
        bool any = false;
        for (uint i = lane; i < size.x * size.y; i += TILE_LANES) {
            uvec2 tile = low + uvec2(i % size.x, i / size.x);
            uint place = tile.y * tiles.x + tile.x;
            if (!tile_missed(tile_distance(view, caster, tile)) && !tile_hidden(view, caster, horizon[first_tile + place])) {
#if TALLY == 1
                atomicAdd(tally[place], 1u);
#else
                atomicAdd(counts[first_tile + place], 1u);
#endif
                any = true;
            }
        }
        if (any) {
            met[map * caster_count + index] = mark;
        }
    }
#if TALLY == 1
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < tiles.x * tiles.y; i += TALLY_THREADS) {
        if (tally[i] != 0u) {
            atomicAdd(counts[first_tile + i], tally[i]);
        }
    }
#endif
}
