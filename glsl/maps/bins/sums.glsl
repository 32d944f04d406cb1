// Sums of optical depth in whole numbers: they depend on the casters alone, not on the order these come in.
// Twin: reference::twin::sums.
#ifndef MAPS_BINS_SUMS_GLSL
#define MAPS_BINS_SUMS_GLSL
#include "world/caster.glsl"

// The bound of a texel's optical depth is added up in 256ths.
const float BOUND_UNITS = 256.0;

// An upper bound of an entry's optical depth, `dark` at most; rounded up. The entry holds its caster's greatest optical
// depth (maps/bins/tiles.glsl).
uint entry_bound(uvec2 entry, float dark) {
    return uint(min(uintBitsToFloat(entry.x), dark) * BOUND_UNITS) + 1u;
}

// A bound is added up in two words, low word first, since one is too small for a million opaque casters in a tile.
void wide_add(inout uvec2 sum, uint value) {
    sum.x += value;
    sum.y += uint(sum.x < value);
}

// Adds `sum` to two words of shared memory that several threads add to.
#define WIDE_ATOMIC_ADD(low, high, sum) atomicAdd(high, (sum).y + uint(atomicAdd(low, (sum).x) > ~(sum).x))

// Units per optical depth of 1: as fine as possible without overflow of 32 bits by a sum of at most `bound`.
float sum_scale(uvec2 bound) {
    int top = bound.y != 0u ? 32 + findMSB(bound.y) : findMSB(bound.x);
    return exp2(float(min(22, 38 - top)));
}
#endif
