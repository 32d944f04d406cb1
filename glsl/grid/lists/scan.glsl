// Exclusive prefix sums of 1,024 values, eight per thread. Source: Blelloch 1990. Twin: a loop.
#ifndef GRID_LISTS_SCAN_GLSL
#define GRID_LISTS_SCAN_GLSL
#include "grid/scan.glsl"

const uint SCANNED = 1024u;

// The sum of sums[first] to sums[end − 1].
uint scan_range(uint first, uint end) {
    uint mine = 0u, all;
    for (uint b = first + gl_LocalInvocationIndex; b < end; b += SCAN_THREADS) {
        mine += sums[b];
    }
    scan_threads(mine, all);
    return all;
}
#endif
