#version 460
// Computes the number of casters drawn before each block of a map, and the number of vertices of all casters. One workgroup per map, one
// run of blocks per thread. Inputs: blocks. Outputs: blocks, the draw's command. Twin: reference::twin::compact::scan.
#include "maps/bins/marks.glsl"

const uint THREADS = 64u;

layout(local_size_x = THREADS) in;

shared uint sums[THREADS];

void main() {
    uint map = gl_WorkGroupID.z, thread = gl_LocalInvocationIndex, count = mark_blocks(), first = map * count;
    uint run = (count + THREADS - 1u) / THREADS;
    uint begin = min(thread * run, count), end = min(begin + run, count);
    uint sum = 0u;
    for (uint i = begin; i < end; ++i) {
        sum += blocks[first + i];
    }
    sums[thread] = sum;
    barrier();
    for (uint step = 1u; step < THREADS; step <<= 1u) {
        uint left = thread >= step ? sums[thread - step] : 0u;
        barrier();
        sums[thread] += left;
        barrier();
    }
    uint before = sums[thread] - sum;
    for (uint i = begin; i < end; ++i) {
        uint casters = blocks[first + i];
        blocks[first + i] = before;
        before += casters;
    }
    if (thread == THREADS - 1u) {
        draws[4u * map] = 6u * before;
        draws[4u * map + 1u] = 1u;
        draws[4u * map + 2u] = draws[4u * map + 3u] = 0u;
    }
}
