// Casters per tile of 8 × 8 pixels of the picture, far to near, cut into parts that are painted side by side. Twins: shading::painter,
// reference::twin::painter.
#ifndef CONSUME_PAINTER_LISTS_GLSL
#define CONSUME_PAINTER_LISTS_GLSL
#extension GL_EXT_scalar_block_layout : require

// An entry: a caster in a tile. Twin: maps::ItemData.
struct Item {
    uint key;    // the tile
    uint index;  // the caster
};

// A part of a tile's list that one workgroup paints. Twin: shading::PartData.
struct Part {
    uint tile;
    uint number;  // of the part, from the farthest, counted from 0
    uint count;   // parts of the tile
    uint slot;    // where the layer of the tile's first part is kept, where there are several parts
};

// Twin: shading::PaintTotals.
struct PaintTotals {
    uint entries;  // as far as there is room
    // VkDispatchIndirectCommand: a workgroup per ENTRY_BLOCK entries.
    uint entry_groups[3];
    uint wanted;        // entries, with room or not
    uint most_wanted;   // of all lists of the frame
    uint sorted;        // where the sorted ones begin
    uint part_entries;  // of a part, at most
    uint slots;         // layers that are kept
    uint parts;
    // VkDispatchIndirectCommand: rows of PART_GROUPS workgroups, one per part.
    uint part_groups[3];
    uint split;  // tiles of several parts
    // VkDispatchIndirectCommand: likewise, one per tile of several parts.
    uint split_groups[3];
};

// Pixels per side of a tile. Twin: TILE.
const uint PAINT_TILE = 8u;
// Casters or tiles per workgroup of the passes that list.
const uint LIST_THREADS = 128u;
// Workgroups per row of an indirect dispatch.
const uint PART_GROUPS = 64u;
// Entries per workgroup of the passes over entries: those of the sort.
CONSTANT(uint, SORT_BLOCK, 512u)
const uint ENTRY_BLOCK = SORT_BLOCK;
const uint NO_SLOT = 0xFFFFFFFFu;
// The box of a caster that covers no pixel. A box is the first and the last pixel that a caster may cover, both included, in a word each: x in
// the lower 16 bits, y in the upper ones.
const uvec2 NO_PIXELS = uvec2(1u, 0u);

uvec2 both(uint word) { return uvec2(word & 0xFFFFu, word >> 16u); }

// The pixel of a thread of the workgroup that paints a tile.
uvec2 tile_pixel(uvec2 size, uint tile, uint thread) {
    uint across = (size.x + PAINT_TILE - 1u) / PAINT_TILE;
    return PAINT_TILE * uvec2(tile % across, tile / across) + uvec2(thread % PAINT_TILE, thread / PAINT_TILE);
}

// The first tile that a box reaches, and how many tiles across and down; 0 for none.
void tiles_of(uvec2 box, out uvec2 first, out uvec2 count) {
    uvec2 low = both(box.x), high = both(box.y);
    first = low / PAINT_TILE;
    count = low.x > high.x ? uvec2(0u) : high / PAINT_TILE - first + 1u;
}
#endif
