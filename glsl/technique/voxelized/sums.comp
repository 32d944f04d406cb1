#version 460
// Computes prefix sums over the sums of 1,024 values each, and numbers that follow from the total. One workgroup. Source: ours. Input and
// output: sums. STEP 0: counts, whose number the host knows. 1: ranks, whose total is the number of distinct nodes. 2: sizes, whose total
// determines where the next level begins. Twin: reference::twin::voxelized, which adds in a loop.
// variants: STEP 0 1 2
layout(local_size_x = 128) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/scan.glsl"

void main() {
    uint scanned = STEP == 0 ? scan_count : STEP == 1 ? levels[level].candidates : failed != 0u ? 0u : levels[level].unique;
    uint first = (STEP == 0 ? scan_at : rank_at) / SCANNED, blocks = (scanned + SCANNED - 1u) / SCANNED;
    uint share = (blocks + SCAN_THREADS - 1u) / SCAN_THREADS;
    uint begin = min(share * gl_LocalInvocationIndex, blocks), end = min(begin + share, blocks);
    uint mine = 0u;
    for (uint b = begin; b < end; ++b) {
        mine += sums[first + b];
    }
    uint all, sum = scan_threads(mine, all);
    for (uint b = begin; b < end; ++b) {
        uint here = sums[first + b];
        sums[first + b] = sum;
        sum += here;
        // The sum overflows 32 bits. After a failure, counts above level 0 are meaningless.
        if (STEP == 0 && sum < here && (level == 0u || failed == 0u)) {
            atomicMax(entries, 0xffffffffu);
            atomicMax(failed, 1u);
        }
    }
    if (gl_LocalInvocationIndex != 0u) {
        return;
    }
    if (STEP == 0) {
        // At level 0 the counts are of bins.
        if (level == 0u) {
            atomicMax(entries, all);
            atomicMax(failed, uint(all > entry_capacity || large > large_capacity || pieces > piece_capacity));
        }
        // The sum before the end is the total.
        if (scan_count % SCANNED == 0u) {
            sums[first + blocks] = all;
            values[scan_at + scan_count] = 0u;
        }
    } else if (STEP == 1) {
        levels[level].base = levels[level].unique;
        levels[level].unique += all;
        set_unique_groups(level, levels[level].unique);
        failed = levels[level].unique > unique_capacity || levels[level].lost > 0u ? 1u : failed;
    } else if (level == 0u) {
        levels[0].at = words;
        words += LEAF_WORDS * levels[0].unique;
    } else {
        levels[level].units = all;
        levels[level].at = words;
        words += HEADER_BITS == 32u ? all : (all + 1u) / 2u;
    }
}
