#version 460
// Does the same as maps/bins/count.comp, for blocks.
// Inputs: maps, casters, horizon, slots. Outputs: counts, totals (both cleared beforehand), met (may contain older marks).
#include "maps/bins/set.glsl"
#include "maps/bins/totals.glsl"
#include "maps/detail/casters.glsl"
#include "maps/rounds.glsl"

layout(local_size_x = BIN_THREADS) in;

BINS_COUNTS(buffer)
BINS_TOTALS(writeonly buffer)
BINS_MET(buffer)
BINS_HORIZON(readonly buffer)
BINS_SLOTS(readonly buffer)

void main() {
    uint map = gl_WorkGroupID.z, index = map_thread() / TILE_LANES, lane = map_thread() % TILE_LANES;
    uvec2 low, high;
    if (index >= caster_count || !caster_touches(maps[map].caster_view, casters[index], low, high)) {
        return;
    }
    View view = maps[map].caster_view;
    Caster caster = casters[index];
    uvec2 tiles = tile_counts(view), size = high - low + 1u;
    bool any = false;
    for (uint t = 0u; t < size.x * size.y; ++t) {
        uvec2 tile = low + uvec2(t % size.x, t / size.x), first, last;
        uint place = (map * tiles.y + tile.y) * tiles.x + tile.x, side = slot_side(slots[place * SLOTS]);
        View fine = finer(view, side);
        if (tile_hidden(view, caster, horizon[place]) || !caster_tiles(fine, caster, first, last)
            || !within_tile(tile, side, first, last)) {
            continue;
        }
        uvec2 blocks = last - first + 1u;
        for (uint i = lane; i < blocks.x * blocks.y; i += TILE_LANES) {
            uvec2 block = first + uvec2(i % blocks.x, i / blocks.x), within = block - tile * side;
            if (!tile_missed(tile_distance(fine, caster, block))) {
                atomicAdd(counts[place * SLOTS + within.y * side + within.x], 1u);
                any = true;
            }
        }
    }
    if (any) {
        met[map * caster_count + index] = mark;
    }
    // This test covers the other passes over casters too: their loops run no more iterations than these.
    if (rounds_ran_out(caster_count)) {
        totals[0].cut_short = 1u;
    }
}
