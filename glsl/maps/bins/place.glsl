// Shared by place.comp and place_fullest.comp: how a tile of a map is listed for the pass that builds it.
#ifndef MAPS_BINS_PLACE_GLSL
#define MAPS_BINS_PLACE_GLSL
#include "maps/bins/set.glsl"
#include "maps/bins/tiles.glsl"
#include "maps/bins/totals.glsl"
#include "maps/detail/blocks.glsl"

// Parts of a tile that has casters, and of one that has none.
CONSTANT(uint, PARTS, 1u)
CONSTANT(uint, EMPTY_PARTS, 0u)

BINS_COUNTS(readonly buffer)
BINS_PARTS(writeonly buffer)
BINS_CURSORS(writeonly buffer)
BINS_TOTALS(buffer)
BINS_SLOTS(readonly buffer)

// Tiles of a map, or with DETAIL the blocks that they may have.
uint bins_a_map() {
    uvec2 tiles = tile_counts(maps[0].volume);
    return tiles.x * tiles.y * (DETAIL ? SLOTS : 1u);
}

// Parts that are listed of a bin with so many casters.
uint parts_wanted(uint bin, uint count) {
    bool built = count > 0u;
    if (DETAIL) {
        uint slot = bin % SLOTS, side = slot_side(slots[bin - slot]);
        built = slot < side * side && slot_place(slots[bin]) != 0u;
    }
    return built ? PARTS : DETAIL ? 0u : EMPTY_PARTS;
}

// Where the entries of a bin stand, for writing and for reading them: at its `place` among those of the same room, or at
// `counted`.
uint first_entry(uint bin, uint place, uint count, uint counted) {
    if (count > 0u && room == 0u) {
        cursors[bin] = counted;
    }
    return room == 0u ? counted : place * room;
}

// Lists so many parts of a bin from a place on.
void list_parts(uint place, uint wanted, uint bin, uint count, uint first) {
    // Where the entries are too few, which is found out and mended after the build, nothing reads past them.
    uint readable = first < capacity ? min(count, room != 0u ? room : capacity - first) : 0u;
    uint a_map = bins_a_map(), tile = bin % a_map, map = bin / a_map;
    for (uint i = 0u; i < wanted; ++i) {
        parts[place + i] = TilePart(tile, map << 8 | i, first, readable);
    }
}
#endif
