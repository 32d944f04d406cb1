#version 460
// Computes the area of all triangles, and the power of two that scales it to a weight below 2^30; from here on, sums are integers. Source:
// none. Inputs: areas of blocks. Output: head. Twin: reference::twin::ism::points.
layout(local_size_x = 128) in;
#include "technique/ism/sample.glsl"

// How much wider a disc is than its point's share of the area requires: discs overlap, since points leave gaps.
const float COVER = 1.25;

shared float parts[BLOCK];

// Returns 2^30 over the next power of two above the area. The area's exponent is clamped to -96 to 127: smaller areas have no weight.
float scale_of(float area) {
    int exponent = int(floatBitsToUint(area) >> 23u) - 127;
    return uintBitsToFloat(uint(127 + 29 - clamp(exponent, -96, 127)) << 23u);
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    float part = 0.0;
    for (uint i = thread; i < block_count(); i += BLOCK) {
        part += uintBitsToFloat(blocks[i]);
    }
    parts[thread] = part;
    barrier();
    for (uint step = BLOCK / 2u; step > 0u; step /= 2u) {
        if (thread < step) {
            parts[thread] += parts[thread + step];
        }
        barrier();
    }
    if (thread == 0u) {
        float area = min(parts[0], FARTHEST);
        head = IsmPoints(scale_of(area), 0u, COVER * sqrt(area / (3.14159265 * float(points))), area);
    }
}
