#version 460
// A point for each stratum of each subset: strata have equal weights, and each of the triangles that share one is met by its share of
// it. Points of neighbouring strata are spread over their triangle. Sources: Ritschel et al. 2008, section 4.1 (points on surfaces);
// Roberts 2018 (the sequence R2). Inputs: triangles, sides, sums, blocks, head. Output: the pool. Invariant: a point keeps its place
// on its triangle as long as areas keep their shares. Twin: reference::twin::ism::points.
layout(local_size_x = 128) in;
#include "ism/sample.glsl"

// 2^32 / g and 2^32 / g², where g³ = g + 1.
const uvec2 R2 = uvec2(3242174889u, 2447445414u);

// The first triangle with a greater sum than `weight`.
uint triangle_at(uint weight) {
    uint low = 0u, high = block_count() - 1u;
    while (low < high) {
        uint middle = (low + high + 1u) / 2u;
        if (blocks[middle] <= weight) {
            low = middle;
        } else {
            high = middle - 1u;
        }
    }
    uint left = weight - blocks[low];
    uint first = low * BLOCK, last = min(first + BLOCK, triangle_count) - 1u;
    while (first < last) {
        uint middle = (first + last) / 2u;
        if (sums[middle] > left) {
            last = middle;
        } else {
            first = middle + 1u;
        }
    }
    return first;
}

// The weight before stratum `stratum`: total · stratum / points, rounded down.
uint weight_before(uint stratum) {
    uint high, low;
    umulExtended(head.total, stratum, high, low);
    uint bits = uint(findMSB(points));
    return bits == 0u ? low : high << (32u - bits) | low >> bits;
}

void main() {
    uint i = (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) * BLOCK + gl_LocalInvocationIndex;
    if (i >= SUBSETS * points) {
        return;
    }
    uint subset = i / points, stratum = i % points;
    uint before = weight_before(stratum), wide = weight_before(stratum + 1u) - before;
    uint within, unused;
    umulExtended(ism_hash(i), wide, within, unused);
    if (head.total == 0u) {
        // Nothing has any area: no light takes a point that is no number.
        pool[i] = IsmPoint(vec3(uintBitsToFloat(0x7fc00000u)), 0u);
        return;
    }
    uint met = triangle_at(before + within);
    Triangle triangle = triangles[met];
    uvec2 place = stratum * R2 + uvec2(ism_hash(subset), ism_hash(subset + SUBSETS));
    precise vec2 at = vec2(place >> 8u) / 16777216.0;
    if (at.x + at.y > 1.0) {
        at = 1.0 - at;
    }
    precise vec3 position = triangle.corners[0] + at.x * (triangle.corners[1] - triangle.corners[0])
                          + at.y * (triangle.corners[2] - triangle.corners[0]);
    int side = sides[met];
    vec3 normal = triangle_normal(triangle);
    pool[i] = IsmPoint(position, pack_normal(side < 0 ? -normal : normal, side != 0));
}
