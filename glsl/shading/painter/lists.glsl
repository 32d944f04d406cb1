// Casters per tile of 8 × 8 pixels of the picture, far to near, split into parts that are painted in parallel. Twins: shading::painter,
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
    uint number;  // index of the part, from the farthest, counted from 0
    uint count;   // number of the tile's parts
    uint slot;    // slot of the layer of the tile's first part, if the tile has several
};

// Twin: shading::PaintTotals.
struct PaintTotals {
    uint entries;  // number of entries stored, at most the capacity
    // VkDispatchIndirectCommand: one workgroup per ENTRY_BLOCK entries.
    uint entry_groups[3];
    uint wanted;        // number of entries needed, which may exceed the capacity
    uint most_wanted;   // greatest `wanted` of all lists of the frame
    uint sorted;        // index of the first sorted entry
    uint part_entries;  // largest number of entries of a part
    uint slots;         // number of layers that are kept
    uint parts;
    // VkDispatchIndirectCommand: rows of PART_GROUPS workgroups, one per part.
    uint part_groups[3];
    uint split;  // number of tiles with several parts
    // VkDispatchIndirectCommand: rows of PART_GROUPS workgroups, one per tile with several parts.
    uint split_groups[3];
};

// Pixels per side of a tile. Twin: TILE.
const uint PAINT_TILE = 8u;
// Number of casters or tiles per workgroup of the passes that build the lists.
const uint LIST_THREADS = 128u;
// Workgroups per row of an indirect dispatch.
const uint PART_GROUPS = 64u;
// Number of entries per workgroup of the passes over entries: the same as in the sort.
CONSTANT(uint, SORT_BLOCK, 512u)
const uint ENTRY_BLOCK = SORT_BLOCK;
const uint NO_SLOT = 0xFFFFFFFFu;
// The box of a caster that covers no pixel. A box is the first and the last pixel that a caster may cover, both included, in one word each:
// x in the lower 16 bits, y in the upper ones.
const uvec2 NO_PIXELS = uvec2(1u, 0u);

uvec2 both(uint word) { return uvec2(word & 0xFFFFu, word >> 16u); }

// The pixel of a thread of the workgroup that paints a tile.
uvec2 tile_pixel(uvec2 size, uint tile, uint thread) {
    uint across = (size.x + PAINT_TILE - 1u) / PAINT_TILE;
    return PAINT_TILE * uvec2(tile % across, tile / across) + uvec2(thread % PAINT_TILE, thread / PAINT_TILE);
}

// First tile that a box reaches, and number of tiles across and down; 0 for none.
void tiles_of(uvec2 box, out uvec2 first, out uvec2 count) {
    uvec2 low = both(box.x), high = both(box.y);
    first = low / PAINT_TILE;
    count = low.x > high.x ? uvec2(0u) : high / PAINT_TILE - first + 1u;
}
#endif
