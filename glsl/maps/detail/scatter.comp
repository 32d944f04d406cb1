#version 460
// Does the same as maps/bins/scatter.comp, for blocks instead of tiles. If all blocks have the same capacity, their entries are in the
// order of the blocks' places. Inputs: maps, casters, cursors, horizon, slots. Outputs: entries; with a fixed capacity also counts, totals
// (both cleared beforehand), met.
#include "maps/bins/set.glsl"
#include "maps/bins/totals.glsl"
#include "maps/detail/casters.glsl"
#include "maps/rounds.glsl"

layout(local_size_x = BIN_THREADS) in;

BINS_COUNTS(buffer)
BINS_CURSORS(buffer)
BINS_TOTALS(buffer)
BINS_ENTRIES(writeonly buffer)
BINS_MET(writeonly buffer)
BINS_HORIZON(readonly buffer)
BINS_SLOTS(readonly buffer)

// Index of a block's next entry; `capacity` if the entry does not fit.
uint next_entry(uint bin) {
    uint place = slot_place(slots[bin]);
    if (room == 0u) {
        return place > 0u ? atomicAdd(cursors[bin], 1u) : capacity;
    }
    uint before = atomicAdd(counts[bin], 1u);
    if (before >= room) {
        atomicMax(totals[0].fullest, before + 1u);
    }
    return before < room && place > 0u ? (place - 1u) * room + before : capacity;
}

void main() {
    uint map = gl_WorkGroupID.z, index = map_thread() / TILE_LANES, lane = map_thread() % TILE_LANES;
    uvec2 low, high;
    if (index >= caster_count || !caster_touches(maps[map].caster_view, casters[index], low, high)) {
        return;
    }
    View view = maps[map].caster_view;
    uint seen = map_casters(map) + index;
    Caster caster = casters[seen];
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
            float distance_square = tile_distance(fine, caster, block);
            if (!tile_missed(distance_square)) {
                uint entry = next_entry(place * SLOTS + within.y * side + within.x);
                any = true;
                if (entry < capacity) {
                    entries[entry] = tile_entry(fine, caster, seen, block, distance_square);
                }
            }
        }
    }
    if (room != 0u && any) {
        met[map * caster_count + index] = mark;
    }
    if (rounds_ran_out(caster_count)) {
        totals[0].cut_short = 1u;
    }
}
