// The bins, for passes with one workgroup per listed part of a tile; finds the part that a workgroup builds.
#ifndef MAPS_BINS_PART_GLSL
#define MAPS_BINS_PART_GLSL
#include "maps/bins/set.glsl"
#include "maps/bins/totals.glsl"
#include "maps/bins/view_caster.glsl"
#include "maps/detail/blocks.glsl"
#include "maps/rounds.glsl"
#include "maps/scene.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/sheet.glsl"

BINS_PARTS(readonly buffer)
BINS_TOTALS(buffer)
#ifndef BINS_ENTRIES_WRITTEN
BINS_ENTRIES(readonly buffer)
#else
BINS_ENTRIES(coherent buffer)
#endif

BINS_SLOTS(readonly buffer)

// Reads the workgroup's part; false past the end of the list. The buffer is padded past the end of the list, so that the part and the
// list's length can be read at the same time.
bool listed_part(out TilePart part) {
    uint place = gl_WorkGroupID.y * BIN_GROUPS_X + gl_WorkGroupID.x;
    part = parts[place];
    return place < totals[0].parts;
}

// To be called after all loops over the part's casters: records whether the driver cut them short.
void end_part(TilePart part) {
    if (rounds_ran_out(part.count)) {
        totals[0].cut_short = 1u;
    }
}

// The word of the part's block, and the number of tiles across and down its map.
uint part_slot(TilePart part, out uvec2 tiles) {
    tiles = (map_size() + 7u) / 8u;
    return slots[part_map(part) * tiles.x * tiles.y * SLOTS + part.tile];
}

// The view of the part's map; with DETAIL, as fine as the part's tile.
View part_view(TilePart part) {
    uvec2 tiles;
    View view = maps[part_map(part)].caster_view;
    return DETAIL ? finer(view, slot_side(part_slot(part, tiles))) : view;
}

// First texel of the part's tile or block, in that view.
uvec2 part_corner(View view, TilePart part) {
    if (DETAIL) {
        uvec2 tiles;
        uint side = slot_side(part_slot(part, tiles)), tile = part.tile / SLOTS, block = part.tile % SLOTS;
        return (uvec2(tile % tiles.x, tile / tiles.x) * side + uvec2(block % side, block / side)) * 8u;
    }
    uint across = (view.width + 7u) / 8u;
    return uvec2(part.tile % across, part.tile / across) * 8u;
}

// Index of a texel's result: map by map in rows; for blocks, block by block.
uint part_texel(View view, TilePart part, uvec2 texel) {
    if (DETAIL) {
        uvec2 tiles, within = texel % 8u;
        return (slot_place(part_slot(part, tiles)) - 1u) * 64u + within.y * 8u + within.x;
    }
    return (part_map(part) * view.height + texel.y) * view.width + texel.x;
}

// The caster of an entry, in the view's axes.
Caster tile_caster(View view, uint entry) { return view_caster(view, casters[entries[entry].y]); }
#endif
