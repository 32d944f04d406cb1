#version 460
// Counts the occupied voxels before each brick, in three steps. STEP 0: each workgroup sums its own run of bricks. STEP 1: one workgroup
// computes the prefix sums of all runs. STEP 2: each workgroup adds the sum of all runs before its own to its bricks. Source: ours. Input:
// bits. Outputs: runs, the first part of masks. Twin: reference::twin::masks::Masks.
// variants: STEP 0 1 2
#include "grid/masks_set.glsl"

const uint THREADS = 64u;

layout(local_size_x = THREADS) in;

// Number of bricks per thread. Twin: grid::masks::RUN.
const uint BRICKS = 16u;

shared uint sums[THREADS];

// The sum over all earlier threads.
uint before_thread(uint thread, uint sum) {
    sums[thread] = sum;
    barrier();
    for (uint step = 1u; step < THREADS; step <<= 1u) {
        uint left = thread >= step ? sums[thread - step] : 0u;
        barrier();
        sums[thread] += left;
        barrier();
    }
    return sums[thread] - sum;
}

uint voxels_of(uint brick) { return uint(bitCount(grid_bits[2u * brick]) + bitCount(grid_bits[2u * brick + 1u])); }

void main() {
    uint thread = gl_LocalInvocationIndex, sum = 0u;
    if (STEP == 1) {
        uint count = grid_level_at(grid.size, 1u) / (THREADS * BRICKS), share = (count + THREADS - 1u) / THREADS;
        uint first = min(thread * share, count), end = min(first + share, count);
        for (uint run = first; run < end; ++run) {
            sum += runs[1u + run];
        }
        uint before = before_thread(thread, sum);
        for (uint run = first; run < end; ++run) {
            uint voxels = runs[1u + run];
            runs[1u + run] = before;
            before += voxels;
        }
        if (thread == THREADS - 1u) {
            runs[0] = before;
        }
        return;
    }
    uint first = BRICKS * (THREADS * gl_WorkGroupID.x + thread);
    for (uint brick = first; brick < first + BRICKS; ++brick) {
        sum += voxels_of(brick);
    }
    uint before = before_thread(thread, sum);
    if (STEP == 0) {
        if (thread == THREADS - 1u) {
            runs[1u + gl_WorkGroupID.x] = before + sum;
        }
        return;
    }
    before += runs[1u + gl_WorkGroupID.x];
    for (uint brick = first; brick < first + BRICKS; ++brick) {
        masks[brick] = before;
        before += voxels_of(brick);
    }
}
