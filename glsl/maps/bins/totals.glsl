// Counts from binning, over all maps. Twins: maps::BinTotals, maps::TilePart.
#ifndef MAPS_BINS_TOTALS_GLSL
#define MAPS_BINS_TOTALS_GLSL
#extension GL_EXT_scalar_block_layout : require

// Workgroups per row of a dispatch over listed parts: enough never to reach the limit of 65,535 rows. Twin: GROUPS_X in maps::bins.
const uint BIN_GROUPS_X = 64u;

struct BinTotals {
    uint entries;       // modulo 2³²
    uint entries_high;  // number of times that the entries passed 2³²
    uint tiles_used;
    uint parts;  // listed parts of tiles
    // VkDispatchIndirectCommand: one workgroup per listed part, and up to 63 more.
    uint groups_x;
    uint groups_y;
    uint groups_z;
    uint cut_short;  // not 0: the driver ended loops over a tile's casters too early
    uint fullest;    // greatest number of casters of a tile
};

// A workgroup's task: a tile, or a part of one.
struct TilePart {
    uint tile;      // index in its map, row by row
    uint map_part;  // index of the map · 256 + index of the part within the tile
    uint first;  // index of its first entry
    uint count;  // number of its entries
};

uint part_map(TilePart part) { return part.map_part >> 8; }

uint part_of_tile(TilePart part) { return part.map_part & 255u; }
#endif
