#version 460
// Where the first item of each digit of each block goes: behind all items of lower digits, and behind the items of the same digit in
// earlier blocks. One workgroup per map. Twin: reference::twin::order::sort. Input and output: counts.
#include "maps/order/sort.glsl"

layout(local_size_x = SORT_THREADS) in;

shared uint totals[DIGITS];

void main() {
    uint map = gl_WorkGroupID.z, thread = gl_LocalInvocationIndex;
    for (uint d = thread; d < DIGITS; d += SORT_THREADS) {
        uint sum = 0u;
        for (uint b = 0u; b < blocks(); ++b) {
            sum += counts[count_place(map, b, d)];
        }
        totals[d] = sum;
    }
    barrier();
    // There are so few totals that one thread's walk costs less than the barriers of a scan.
    if (thread == 0u) {
        uint sum = 0u;
        for (uint d = 0u; d < DIGITS; ++d) {
            uint total = totals[d];
            totals[d] = sum;
            sum += total;
        }
    }
    barrier();
    for (uint d = thread; d < DIGITS; d += SORT_THREADS) {
        uint sum = totals[d];
        for (uint b = 0u; b < blocks(); ++b) {
            uint here = counts[count_place(map, b, d)];
            counts[count_place(map, b, d)] = sum;
            sum += here;
        }
    }
}
