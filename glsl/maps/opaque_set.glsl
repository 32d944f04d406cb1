// Set 1 for drawing opaque maps in compute: the depths, and the list of triangles that are left to whole workgroups.
// Bound by maps::opaque_compute.
#ifndef MAPS_OPAQUE_SET_GLSL
#define MAPS_OPAQUE_SET_GLSL
#include "maps/scene.glsl"

// set 1: maps_opaque
// Depths of all maps as float bits, which compare like the depths since none is negative. See opaque_corner in maps/opaque.glsl.
layout(set = 1, binding = 0, r32ui) uniform uimage2D depths;

// Extent of the list. Twin: maps::OpaqueTotals.
struct OpaqueTotals {
    uint items;  // number of items requested; past OPAQUE_MOST_ITEMS no longer exact
    // VkDispatchIndirectCommand: one workgroup per item that fits into the list, and up to 63 more.
    uint groups_x;
    uint groups_y;
    uint groups_z;
};

layout(set = 1, binding = 1, scalar) buffer Totals { OpaqueTotals totals; };

// A share of the tiles of a triangle. Twin: maps::OpaqueItem.
struct OpaqueItem {
    uint triangle;
    uint map_share;  // map · OPAQUE_MOST_SHARES + index of the share
};

layout(set = 1, binding = 2, scalar) buffer OpaqueItems { OpaqueItem items[]; };

layout(push_constant, scalar) uniform OpaquePush {
    uint triangle_count;
    uint capacity;  // of the list
    uint rows;      // number of maps stacked vertically in the image
    uint first_map; // the map of workgroups at z = 0
};

// Workgroups per row of the list's dispatch. Twin: ITEMS_X in maps::opaque_compute.
const uint OPAQUE_ITEMS_X = 64u;
// Largest number of shares into which the tiles of one triangle are divided: so few that no count of items exceeds 32 bits.
const uint OPAQUE_MOST_SHARES = 4096u;
// Once this many items are counted, no more are listed: the workgroups that find large triangles draw them themselves.
const uint OPAQUE_MOST_ITEMS = 0x80000000u;

// Upper left texel of a map in the image of all maps. Twin: maps::opaque_corner.
ivec2 opaque_map_corner(View view, uint map) { return ivec2(map / rows * view.width, map % rows * view.height); }
#endif
