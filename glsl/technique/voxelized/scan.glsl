// Sums before each of 1,024 values, eight a thread. Twin: a loop.
#ifndef TECHNIQUE_VOXELIZED_SCAN_GLSL
#define TECHNIQUE_VOXELIZED_SCAN_GLSL

const uint SCAN_THREADS = 128u;
shared uint scan_sums[SCAN_THREADS];

// The sum of `mine` over all threads before this one; in `all`, over all.
uint scan_threads(uint mine, out uint all) {
    uint thread = gl_LocalInvocationIndex;
    scan_sums[thread] = mine;
    for (uint step = 1u; step < SCAN_THREADS; step *= 2u) {
        barrier();
        uint other = thread >= step ? scan_sums[thread - step] : 0u;
        barrier();
        scan_sums[thread] += other;
    }
    barrier();
    all = scan_sums[SCAN_THREADS - 1u];
    uint sum = scan_sums[thread] - mine;
    barrier();
    return sum;
}

// Writes the sums before eight values of each thread to values[first + ...], and that of all to sums.
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
