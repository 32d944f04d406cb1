// Layout of curves while fragments insert into them. A group is eight texels of a row: the first pair of nodes of each texel, then the
// second pair of each, and so on, in the memory that the eight curves occupy afterwards. Neighbouring fragments then share cache lines;
// otherwise each would need its own. technique/avsm/pack.comp reorders the pairs curve by curve.
#ifndef TECHNIQUE_AVSM_INTERLEAVED_LAYOUT_GLSL
#define TECHNIQUE_AVSM_INTERLEAVED_LAYOUT_GLSL
#include "maps/curve/node.glsl"

// Returns the index of pair i of a texel, in pairs. `x`: the texel's column. `row`: index of the row's first texel among all texels. The
// last group of a row may have fewer than eight texels.
uint pair_place(uint row, uint x, uint width, uint i) {
    uint first = x & ~7u;
    return (row + first) * (NODES / 2) + i * min(8u, width - first) + (x - first);
}
#endif
