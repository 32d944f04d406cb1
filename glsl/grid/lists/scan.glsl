// Sums before each of 1,024 values, eight a thread. Source: Blelloch 1990. Twin: a loop.
#ifndef GRID_LISTS_SCAN_GLSL
#define GRID_LISTS_SCAN_GLSL

const uint SCAN_THREADS = 128u;
const uint SCANNED = 1024u;
shared uint scan_sums[SCAN_THREADS];

// The sum of `mine` over all threads before this one; in `all`, over all.
uint scan_threads(uint mine, out uint all) {
    uint thread = gl_LocalInvocationIndex;
    barrier();
    scan_sums[thread] = mine;
    for (uint step = 1u; step < SCAN_THREADS; step *= 2u) {
        barrier();
        uint other = thread >= step ? scan_sums[thread - step] : 0u;
        barrier();
        scan_sums[thread] += other;
    }
    barrier();
    all = scan_sums[SCAN_THREADS - 1u];
    return scan_sums[thread] - mine;
}

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
