// Prefix sums of 1,024 values, eight per thread. Twin: a loop.
#ifndef TECHNIQUE_VOXELIZED_SCAN_GLSL
#define TECHNIQUE_VOXELIZED_SCAN_GLSL
#include "grid/scan.glsl"

// Writes the sum before each of a thread's eight values to values[first + ...], and the sum of all values to sums.
#define SCAN_BLOCK(first, value_of)                                         \
    {                                                                       \
        uint scan_at = (first) + 8u * gl_LocalInvocationIndex, scan_mine = 0u; \
        uint scan_before[8];                                                \
        for (uint v = 0u; v < 8u; ++v) {                                    \
            scan_before[v] = scan_mine;                                     \
            scan_mine += value_of(scan_at + v);                             \
        }                                                                   \
        uint scan_all, scan_base = scan_threads(scan_mine, scan_all);       \
        for (uint v = 0u; v < 8u; ++v) {                                    \
            values[scan_at + v] = scan_base + scan_before[v];               \
        }                                                                   \
        if (gl_LocalInvocationIndex == 0u) {                                \
            sums[(first) / SCANNED] = scan_all;                             \
        }                                                                   \
    }
#endif
