// The set of the bins. A shader declares the buffers that it reads or writes: `BINS_COUNTS(readonly buffer)`. Bound by maps::Bins.
// set 1: bins
#ifndef MAPS_BINS_SET_GLSL
#define MAPS_BINS_SET_GLSL
// Number of casters of each tile: map by map, rows of tiles; with DETAIL, of each slot (glsl/maps/detail/blocks.glsl).
#define BINS_COUNTS(access) layout(set = 1, binding = 0, scalar) access Counts { uint counts[]; };
// The listed parts of tiles.
#define BINS_PARTS(access) layout(set = 1, binding = 1, scalar) access Parts { TilePart parts[]; };
// Index at which the next entry of each tile is written.
#define BINS_CURSORS(access) layout(set = 1, binding = 2, scalar) access Cursors { uint cursors[]; };
#define BINS_TOTALS(access) layout(set = 1, binding = 3, scalar) access Totals { BinTotals totals[]; };
// An entry: a caster's sort key or its greatest optical depth, and its index.
#define BINS_ENTRIES(access) layout(set = 1, binding = 4, scalar) access Entries { uvec2 entries[]; };
// Whether a caster of a map is in any tile.
#define BINS_MET(access) layout(set = 1, binding = 5, scalar) access Met { uint met[]; };
// z in the map's volume view beyond which no light reaches: map by map, rows of tiles.
#define BINS_HORIZON(access) layout(set = 1, binding = 6, scalar) access Horizon { float horizon[]; };
// Resolution of tiles: glsl/maps/detail/blocks.glsl.
#define BINS_SLOTS(access) layout(set = 1, binding = 7, scalar) access Slots { uint slots[]; };
#endif
