// Prefix sums of 1,024 values (each value's is the sum before it), eight per thread. Source: Blelloch 1990. Twin: a
// loop.
#ifndef GRID_LISTS_SCAN_GLSL
#define GRID_LISTS_SCAN_GLSL
#include "grid/scan.glsl"

const uint SCANNED = 1024u;

// The sum of sums[first] and those behind it, before sums[end].
uint scan_range(uint first, uint end) {
    uint mine = 0u, all;
    for (uint b = first + gl_LocalInvocationIndex; b < end; b += SCAN_THREADS) {
        mine += sums[b];
    }
    scan_threads(mine, all);
    return all;
}
#endif
