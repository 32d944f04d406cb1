#version 460
// Gives each tile of each map its place among the entries, in any order: tiles do not depend on each other. With room for
// each tile it has one already, and entries in it. Lists the parts
// into which tiles are cut, one a workgroup: PARTS of a tile that has casters, EMPTY_PARTS of one that has none.
// With DETAIL the same of blocks: those that have a place are built.
// Inputs: counts, slots. Outputs: cursors, where scatter begins to write, parts, totals (cleared before).
#include "bins/tiles.glsl"
#include "bins/totals.glsl"
#include "detail/blocks.glsl"

layout(local_size_x = BIN_THREADS) in;

CONSTANT(uint, PARTS, 1u)
CONSTANT(uint, EMPTY_PARTS, 0u)

layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 1, scalar) writeonly buffer Parts { TilePart parts[]; };
layout(set = 1, binding = 2, scalar) writeonly buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 3, scalar) buffer Totals { BinTotals totals[]; };
layout(set = 1, binding = 7, scalar) readonly buffer Slots { uint slots[]; };

void main() {
    uint map = gl_WorkGroupID.z, tile = map_thread();
    if (tile == 0u && map == 0u) {
        totals[0].groups_x = BIN_GROUPS_X;
        totals[0].groups_z = 1u;
    }
    uvec2 tiles = tile_counts(maps[map].volume);
    uint tile_total = tiles.x * tiles.y * (DETAIL ? SLOTS : 1u);
    if (tile >= tile_total) {
        return;
    }
    uint count = counts[map * tile_total + tile], first = 0u;
    if (count > 0u) {
        first = atomicAdd(totals[0].entries, count);
        if (first + count < first) {
            atomicAdd(totals[0].entries_high, 1u);
        }
        atomicAdd(totals[0].tiles_used, 1u);
        atomicMax(totals[0].fullest, count);
        if (room == 0u) {
            cursors[map * tile_total + tile] = first;
        } else {
            first = (map * tile_total + tile) * room;
        }
    }
    // Where the entries are too few, which is found out and mended after the build, nobody reads past them.
    uint readable = first < capacity ? min(count, room != 0u ? room : capacity - first) : 0u;
    bool built = DETAIL ? slot_place(slots[map * tile_total + tile]) != 0u : count > 0u;
    uint wanted = built ? PARTS : DETAIL ? 0u : EMPTY_PARTS;
    if (wanted > 0u) {
        uint place = atomicAdd(totals[0].parts, wanted);
        for (uint i = 0u; i < wanted; ++i) {
            parts[place + i] = TilePart(tile, map << 8 | i, first, readable);
        }
        atomicMax(totals[0].groups_y, (place + wanted - 1u) / BIN_GROUPS_X + 1u);
    }
}
