// Sums of optical depth as integers: they depend only on the casters, not on the casters' order.
// Twin: reference::twin::sums.
#ifndef MAPS_BINS_SUMS_GLSL
#define MAPS_BINS_SUMS_GLSL
#include "world/caster.glsl"

// The bound of a texel's optical depth is summed in 256ths.
const float BOUND_UNITS = 256.0;

// Upper bound of an entry's optical depth, at most `dark`; rounded up. The entry holds its caster's greatest optical depth
// (maps/bins/tiles.glsl).
uint entry_bound(uvec2 entry, float dark) {
    return uint(min(uintBitsToFloat(entry.x), dark) * BOUND_UNITS) + 1u;
}

// A bound is summed in two words, low word first, since one word is too small for a million opaque casters in a tile.
void wide_add(inout uvec2 sum, uint value) {
    sum.x += value;
    sum.y += uint(sum.x < value);
}

// Adds `sum` to two words of shared memory that several threads add to.
#define WIDE_ATOMIC_ADD(low, high, sum) atomicAdd(high, (sum).y + uint(atomicAdd(low, (sum).x) > ~(sum).x))

// Number of units per optical depth of 1: as fine as possible without a sum of at most `bound` overflowing 32 bits.
float sum_scale(uvec2 bound) {
    int top = bound.y != 0u ? 32 + findMSB(bound.y) : findMSB(bound.x);
    return exp2(float(min(22, 38 - top)));
}
#endif
