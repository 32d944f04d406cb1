// Cells of a volume: boxes of even extinction, turned as the volume is. Packed as a Gaussian is, but for the exponent that marks it and
// the radius, which is half the diagonal. Source: docs/notebook/volumes.md. Twins: scene::Volume, reference::twin::cell,
// reference::truth::volume::cell.
#ifndef WORLD_CELL_GLSL
#define WORLD_CELL_GLSL
#include "world/gaussian.glsl"

// Bits of an axis by which a caster is a cell. Twin: CELL_MARK.
const uint CELL_MARK = 0x72000000u;

bool cell_marked(vec3 axis) { return (floatBitsToUint(axis.x) & 0x7F800000u) == CELL_MARK; }

// Unit vectors and half of the sides along them, world units; in `deviations`.
GaussianShape cell_shape(float radius, vec3 packed) {
    GaussianShape shape = gaussian_shape(GAUSSIAN_REACH, packed);
    shape.deviations *= radius * inversesqrt(dot(shape.deviations, shape.deviations));
    return shape;
}

// A ray that leaves a side by less than this of its length is along it.
const float CELL_ALONG = 1e-6;
// A side is so much of a half of the cell's width soft to a ray along it, to each side.
const float CELL_SOFT = 1e-3;

// z from which and to which a ray is inside, and how long. Rounding alone would decide whether a ray along a side is in or out: of two
// cells that share the side both might have it, or none. So each has the share of it that it has of a strip about the side, around the middle
// of its whole chord: together they have it once.
bool cell_overlap(Ray ray, vec3 position, float radius, vec3 packed, out vec3 z) {
    GaussianShape shape = cell_shape(radius, packed);
    vec3 offset = position - ray.origin;
    float square = dot(ray.direction, ray.direction), least = CELL_ALONG * sqrt(square), share = 1.0;
    float nearest = dot(offset, ray.direction) / square, low = -FARTHEST, high = FARTHEST;
    vec3 across = offset - nearest * ray.direction;
    for (uint i = 0u; i < 3u; ++i) {
        float along = dot(shape.axes[i], ray.direction), from = dot(shape.axes[i], across), side = shape.deviations[i];
        if (abs(along) < least) {
            share *= clamp(0.5 + (side - abs(from)) / (2.0 * CELL_SOFT * side), 0.0, 1.0);
            continue;
        }
        float reach = along < 0.0 ? -side : side;
        low = max(low, (from - reach) / along);
        high = min(high, (from + reach) / along);
    }
    float middle = nearest + 0.5 * (low + high), half_chord = 0.5 * share * (high - low);
    z = vec3(middle - half_chord, middle + half_chord, 2.0 * half_chord);
    return half_chord > 0.0;
}

// Low to high along right (x, y) and along up (z, w) of the box in a parallel view; of a cell in the view's axes.
vec4 cell_extent(vec3 centre, float radius, vec3 packed) {
    GaussianShape shape = cell_shape(radius, packed);
    vec2 reach = abs(shape.axes[0].xy) * shape.deviations.x + abs(shape.axes[1].xy) * shape.deviations.y +
                 abs(shape.axes[2].xy) * shape.deviations.z;
    return vec4(centre.x - reach.x, centre.x + reach.x, centre.y - reach.y, centre.y + reach.y);
}
#endif
