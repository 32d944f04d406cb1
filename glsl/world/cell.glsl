// Cells of a volume: boxes of constant extinction, rotated with the volume. A cell is packed like a splat, with two differences: an
// exponent marks it as a cell, and its radius is half its diagonal. Source: docs/notebook/volumes.md. Twins: scene::Volume,
// reference::twin::cell, reference::truth::volume::cell.
#ifndef WORLD_CELL_GLSL
#define WORLD_CELL_GLSL
#include "world/splat.glsl"

// Bits of the axis that mark a caster as a cell. Twin: CELL_MARK.
const uint CELL_MARK = 0x72000000u;

bool cell_marked(vec3 axis) { return (floatBitsToUint(axis.x) & 0x7F800000u) == CELL_MARK; }

// A cell's unit vectors; `deviations` holds its half-extents along them, in world units.
SplatShape cell_shape(float radius, vec3 packed) {
    SplatShape shape = splat_shape(SPLAT_REACH, packed);
    shape.deviations *= radius * inversesqrt(dot(shape.deviations, shape.deviations));
    return shape;
}

// A ray counts as parallel to a side if it moves away from the side by less than this fraction of its length.
const float CELL_ALONG = 1e-6;
// For a ray parallel to a side, that side is softened over this fraction of the cell's half-extent, inwards and outwards.
const float CELL_SOFT = 1e-3;

// Returns where a ray is inside the cell: from z.x to z.y, with length z.z. For a ray along a side, rounding alone would decide whether the
// ray is inside: of two cells that share the side, both might count the ray, or neither. So each side has a soft strip around it. Depending
// on the ray's position in the strip, each of the two cells keeps a fraction of its chord, around the chord's midpoint, and the two
// fractions add up to 1.
bool cell_overlap(Ray ray, vec3 position, float radius, vec3 packed, out vec3 z) {
    SplatShape shape = cell_shape(radius, packed);
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

// Bounds of a cell in the axes of a parallel view: low to high along right (x, y) and along up (z, w).
vec4 cell_extent(vec3 centre, float radius, vec3 packed) {
    SplatShape shape = cell_shape(radius, packed);
    vec2 reach = abs(shape.axes[0].xy) * shape.deviations.x + abs(shape.axes[1].xy) * shape.deviations.y +
                 abs(shape.axes[2].xy) * shape.deviations.z;
    return vec4(centre.x - reach.x, centre.x + reach.x, centre.y - reach.y, centre.y + reach.y);
}
#endif
