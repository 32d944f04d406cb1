// Exclusive prefix sums over the threads of a workgroup of 128. Source: Blelloch 1990. Twin: a loop.
#ifndef GRID_SCAN_GLSL
#define GRID_SCAN_GLSL

const uint SCAN_THREADS = 128u;
shared uint scan_sums[SCAN_THREADS];

// Returns the sum of `mine` over all threads before this one; `all`: the sum over all threads.
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
#endif
