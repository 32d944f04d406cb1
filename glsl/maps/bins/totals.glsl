// Counts of binning, over all maps. Twins: maps::BinTotals, maps::TilePart.
#ifndef MAPS_BINS_TOTALS_GLSL
#define MAPS_BINS_TOTALS_GLSL
#extension GL_EXT_scalar_block_layout : require

// Workgroups per row of a dispatch over listed parts: enough that the limit of 65,535 rows is never met. Twin: GROUPS_X
// in maps::bins.
const uint BIN_GROUPS_X = 64u;

struct BinTotals {
    uint entries;       // modulo 2³²
    uint entries_high;  // how often the entries have passed 2³²
    uint tiles_used;
    uint parts;  // listed parts of tiles
    // VkDispatchIndirectCommand: one workgroup per listed part, and up to 63 more.
    uint groups_x;
    uint groups_y;
    uint groups_z;
    uint cut_short;  // not 0: the driver ended loops over a tile's casters before their time
    uint fullest;    // most casters of a tile
};

// A workgroup's task: a tile, or a part of one.
struct TilePart {
    uint tile;      // of its map, row after row
    uint map_part;  // which of the maps · 256 + which part of the tile
    uint first;  // of the tile's entries, the part's first
    uint count;  // how many entries the part has
};

uint part_map(TilePart part) { return part.map_part >> 8; }

uint part_of_tile(TilePart part) { return part.map_part & 255u; }
#endif
