// Where curves stand while fragments insert into them: the first pair of nodes of each of eight texels of a row, the second
// of each, and so on, in the room that the eight have afterwards. Fragments beside each other then read and write one line of
// memory, not one each. technique/avsm/pack.comp puts the nodes of a texel one after the other.
#ifndef TECHNIQUE_AVSM_BESIDE_GLSL
#define TECHNIQUE_AVSM_BESIDE_GLSL
#include "maps/curve/node.glsl"

// Where pair i of a texel stands, in pairs: x in its row, `row` the place of the row's first texel among all. At a row's end
// there are fewer than eight.
uint pair_place(uint row, uint x, uint width, uint i) {
    uint first = x & ~7u;
    return (row + first) * (NODES / 2) + i * min(8u, width - first) + (x - first);
}
#endif
