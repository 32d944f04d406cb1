#version 460
// Writes an entry of each caster into each of its tiles, in any order: the shader that reads a tile sorts it or needs no order, and no two
// entries of a tile are equal. If all tiles have the same capacity (`room` is not 0), count.comp does not run: counts are the cursors, and
// this pass marks the casters that touch a tile. Inputs: maps, casters, cursors, horizon. Outputs: entries. With a fixed capacity there are
// three more outputs. The counts are cleared beforehand. So are the totals, of which only `fullest` is written: the greatest number of
// casters of any tile that exceeds its capacity. `met` is not cleared: a caster in no tile keeps an older mark.

// TALLY: as in count.comp. With TALLY 1, a workgroup reserves all its entries of a tile at once.
// variants: TALLY 0 1
#include "maps/bins/set.glsl"
#include "maps/bins/tiles.glsl"
#include "maps/bins/tally.glsl"
#include "maps/bins/totals.glsl"

BINS_COUNTS(buffer)
BINS_CURSORS(buffer)
BINS_TOTALS(buffer)
BINS_ENTRIES(writeonly buffer)
BINS_MET(writeonly buffer)
BINS_HORIZON(readonly buffer)

#if TALLY == 1
// The first round counts the entries of each tile, the second writes them.
const uint ROUNDS = 2u;
#else
const uint ROUNDS = 1u;
#endif

void main() {
    uint map = gl_WorkGroupID.z, lane = tally_lane();
    View view = maps[map].caster_view;
    uvec2 tiles = tile_counts(view);
    uint first_tile = map * tiles.x * tiles.y;
    tally_clear(tiles);
    for (uint round = 1u; round <= ROUNDS; ++round) {
        for (uint turn = 0u; turn < TALLY_TURNS; ++turn) {
            uint index = tally_caster(turn);
            uvec2 low, high;
            if (index >= caster_count || !caster_tiles(view, casters[index], low, high)) {
                continue;
            }
            uint seen = map_casters(map) + index;
            Caster caster = casters[seen];
            uvec2 size = high - low + 1u;
            bool any = false;
            for (uint i = lane; i < size.x * size.y; i += TILE_LANES) {
                uvec2 tile = low + uvec2(i % size.x, i / size.x);
                uint place = tile.y * tiles.x + tile.x;
                float distance_square = tile_distance(view, caster, tile);
                if (tile_missed(distance_square) || tile_hidden(view, caster, horizon[first_tile + place])) {
                    continue;
                }
#if TALLY == 1
                uint slot = atomicAdd(tally[place], 1u);
#else
                uint slot = capacity;
                if (room == 0u) {
                    slot = atomicAdd(cursors[first_tile + place], 1u);
                } else {
                    uint before = atomicAdd(counts[first_tile + place], 1u);
                    if (before < room) {
                        slot = (first_tile + place) * room + before;
                    } else {
                        atomicMax(totals[0].fullest, before + 1u);
                    }
                }
#endif
                any = true;
                if (round == ROUNDS && slot < capacity) {
                    entries[slot] = tile_entry(view, caster, seen, tile, distance_square);
                }
            }
            if (room != 0u && any) {
                met[map * caster_count + index] = mark;
            }
        }
#if TALLY == 1
        barrier();
        for (uint i = gl_LocalInvocationIndex; round == 1u && i < tiles.x * tiles.y; i += TALLY_THREADS) {
            if (tally[i] != 0u) {
                tally[i] = atomicAdd(cursors[first_tile + i], tally[i]);
            }
        }
        barrier();
#endif
    }
}
