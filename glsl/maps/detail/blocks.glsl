// Tiles at a multiple of their map's resolution: a tile of 8×8 texels of the map is side × side blocks of 8×8 texels, with a side from 1 to
// 8. The table has SLOTS words per tile: word y · side + x belongs to block (x, y). It holds the tile's side, and either the block's place
// among the curves or a mark that no caster touches the block. Words from side² on are undefined. Twin: reference::twin::detail.
#ifndef MAPS_DETAIL_BLOCKS_GLSL
#define MAPS_DETAIL_BLOCKS_GLSL
#include "world/view.glsl"

// Whether each tile has its own side; otherwise every tile is one block.
CONSTANT(bool, DETAIL, false)

const uint SLOTS = 64u;

uint slot_word(uint side, uint place) { return side << 28 | place; }

uint slot_side(uint word) { return word >> 28; }

// 0 if no caster touches the block, else 1 + its place.
uint slot_place(uint word) { return word & 0x0FFFFFFFu; }

// The map's view at `side` times its resolution.
View finer(View view, uint side) {
    view.width *= side;
    view.height *= side;
    return view;
}
#endif
