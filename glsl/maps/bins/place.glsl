// Shared by place.comp and place_fullest.comp: adds a tile to the list for the pass that builds it.
#ifndef MAPS_BINS_PLACE_GLSL
#define MAPS_BINS_PLACE_GLSL
#include "maps/bins/set.glsl"
#include "maps/bins/tiles.glsl"
#include "maps/bins/totals.glsl"
#include "maps/detail/blocks.glsl"

// Number of parts listed for a tile with casters, and for a tile without.
CONSTANT(uint, PARTS, 1u)
CONSTANT(uint, EMPTY_PARTS, 0u)

BINS_COUNTS(readonly buffer)
BINS_PARTS(writeonly buffer)
BINS_CURSORS(writeonly buffer)
BINS_TOTALS(buffer)
BINS_SLOTS(readonly buffer)

// Number of tiles of a map, or with DETAIL of the blocks that they may have.
uint bins_per_map() {
    uvec2 tiles = tile_counts(maps[0].caster_view);
    return tiles.x * tiles.y * (DETAIL ? SLOTS : 1u);
}

// Number of parts to list for a bin with `count` casters.
uint parts_wanted(uint bin, uint count) {
    bool built = count > 0u;
    if (DETAIL) {
        uint slot = bin % SLOTS, side = slot_side(slots[bin - slot]);
        built = slot < side * side && slot_place(slots[bin]) != 0u;
    }
    return built ? PARTS : DETAIL ? 0u : EMPTY_PARTS;
}

// Index of a bin's first entry, for writing and for reading: `place` times the capacity if all bins have the same capacity, else `counted`.
uint first_entry(uint bin, uint place, uint count, uint counted) {
    if (count > 0u && room == 0u) {
        cursors[bin] = counted;
    }
    return room == 0u ? counted : place * room;
}

// Lists `wanted` parts of a bin, from `place` on.
void list_parts(uint place, uint wanted, uint bin, uint count, uint first) {
    // The buffer of entries may be too small, which is detected and fixed after the build: nothing reads past its end.
    uint readable = first < capacity ? min(count, room != 0u ? room : capacity - first) : 0u;
    uint per_map = bins_per_map(), tile = bin % per_map, map = bin / per_map;
    for (uint i = 0u; i < wanted; ++i) {
        parts[place + i] = TilePart(tile, map << 8 | i, first, readable);
    }
}
#endif
