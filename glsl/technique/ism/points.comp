#version 460
// Places a point in each stratum of each subset. Strata divide the weight of all triangles, their scaled area, into equal parts. If a
// stratum spans several triangles, its point falls on one of them at random, with a probability equal to the triangle's share of the
// stratum. Points of neighbouring strata are spread over their triangle. Sources: Ritschel et al. 2008, section 4.1 (points on surfaces);
// Roberts 2018 (the sequence R2). A point in a hole is NaN, which no light takes. Inputs: triangles, sides, sums, blocks, head. Output: the
// pool. Invariant: a point keeps its position on its triangle as long as each triangle keeps its share of the total area. Twin:
// reference::twin::ism::points.
layout(local_size_x = 128) in;
#include "technique/ism/sample.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/alpha.glsl"

// Whether neighbours in the pool are neighbours on their triangles, for technique/ism/adapt.comp.
CONSTANT(bool, ISM_ADAPTIVE, false)

// A point that no light takes.
IsmPoint no_point() { return IsmPoint(vec3(uintBitsToFloat(0x7fc00000u)), 0u); }

// 2^32 / g and 2^32 / g², where g³ = g + 1.
const uvec2 R2 = uvec2(3242174889u, 2447445414u);

// Returns the first triangle whose sum exceeds `weight`.
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

// Returns the weight before stratum `stratum` of 2^bits: total · stratum / 2^bits, rounded down.
uint weight_before(uint stratum, uint bits) {
    uint high, low;
    umulExtended(head.total, stratum, high, low);
    return bits == 0u ? low : high << (32u - bits) | low >> bits;
}

// Number of times that a triangle is halved to find a position on the curve through it.
const uint HALVINGS = 20u;
// A side counts as longer only if its squared length exceeds the greatest squared length of the sides before it by this factor.
const float LONGER = 1.01;

// Returns the position in a triangle at `weight` / `wide` of the length of a curve that fills the triangle. The triangle is halved at the
// midpoint of its longest side, each half at the midpoint of a side that the cut left whole, and so on. The curve runs through one half,
// then the other, so that neighbours on the curve are neighbours in the triangle. All coordinates are sums of halves, which are exact.
vec2 place_at(Triangle triangle, uint weight, uint wide) {
    vec2 corners[3] = { vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.0, 1.0) };
    uint longest = 0u;
    float most = 0.0;
    for (uint i = 0u; i < 3u; ++i) {
        precise vec3 side = triangle.corners[(i + 1u) % 3u] - triangle.corners[i];
        precise float square = side.x * side.x + side.y * side.y + side.z * side.z;
        if (square > LONGER * most) {
            longest = i;
            most = square;
        }
    }
    vec2 from = corners[longest], to = corners[(longest + 1u) % 3u], apex = corners[(longest + 2u) % 3u];
    for (uint i = 0u; i < HALVINGS; ++i) {
        vec2 middle = 0.5 * (from + to);
        weight *= 2u;
        if (weight < wide) {
            to = apex;
        } else {
            weight -= wide;
            from = apex;
        }
        apex = middle;
    }
    return apex;
}

void main() {
    uint i = (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) * BLOCK + gl_LocalInvocationIndex;
    if (i >= SUBSETS * points) {
        return;
    }
    // If the density adapts, all subsets together are ordered along the curve.
    uint subset = i / points, stratum = ISM_ADAPTIVE ? i : i % points;
    uint bits = uint(findMSB(ISM_ADAPTIVE ? SUBSETS * points : points));
    uint before = weight_before(stratum, bits), wide = weight_before(stratum + 1u, bits) - before;
    uint within, unused;
    umulExtended(ism_hash(i), wide, within, unused);
    if (head.total == 0u) {
        // No triangle has any area.
        pool[i] = no_point();
        return;
    }
    uint met = triangle_at(before + within);
    Triangle triangle = triangles[met];
    precise vec2 at;
    if (ISM_ADAPTIVE) {
        uint first = met % BLOCK == 0u ? 0u : sums[met - 1u];
        at = place_at(triangle, before + within - blocks[met / BLOCK] - first, sums[met] - first);
    } else {
        uvec2 place = stratum * R2 + uvec2(ism_hash(subset), ism_hash(subset + SUBSETS));
        at = vec2(place >> 8u) / 16777216.0;
        if (at.x + at.y > 1.0) {
            at = 1.0 - at;
        }
    }
    if (!alpha_blocks(met, at)) {
        pool[i] = no_point();
        return;
    }
    precise vec3 position = triangle.corners[0] + at.x * (triangle.corners[1] - triangle.corners[0])
                          + at.y * (triangle.corners[2] - triangle.corners[0]);
    int side = sides[met];
    vec3 normal = triangle_normal(triangle);
    pool[i] = IsmPoint(position, pack_normal(side < 0 ? -normal : normal, side != 0));
}
