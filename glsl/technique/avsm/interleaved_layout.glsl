// The layout of curves while fragments insert into them. Eight texels in a row stand together: first the first pair of nodes of each of
// them, then the second pair of each, and so on. They use the same memory that the eight curves take afterwards. Neighbouring fragments
// then read and write the same cache line; otherwise each of them would need its own. technique/avsm/pack.comp reorders the pairs, so that
// they stand curve by curve.
#ifndef TECHNIQUE_AVSM_INTERLEAVED_LAYOUT_GLSL
#define TECHNIQUE_AVSM_INTERLEAVED_LAYOUT_GLSL
#include "maps/curve/node.glsl"

// The place of pair i of a texel, counted in pairs. `x`: the texel's place in its row. `row`: the place of the row's first texel among all
// texels. The last group of texels of a row may have fewer than eight.
uint pair_place(uint row, uint x, uint width, uint i) {
    uint first = x & ~7u;
    return (row + first) * (NODES / 2) + i * min(8u, width - first) + (x - first);
}
#endif
