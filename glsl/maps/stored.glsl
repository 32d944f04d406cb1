// The depth that an opaque map stores where the ray through a texel's centre hits a surface: slightly more than the true one, so that
// rounding alone casts no shadow. Included by all passes that draw opaque maps. With EXACT it is bit-identical on every device; without
// EXACT it is computed with the device's own, faster division. Twin: reference::twin::opaque::stored.
#ifndef MAPS_STORED_GLSL
#define MAPS_STORED_GLSL
#include "world/view.glsl"

// Largest amount by which the map's format lowers a depth when it is stored; 0 for float formats, whose rounding error stored_depth
// includes.
CONSTANT(float, OPAQUE_STEP, 0.0)

#ifdef EXACT
#include "maps/exact.glsl"
#define PRECISE precise
#else
#define PRECISE
float reciprocal(float a) { return 1.0 / a; }
float longest3(vec3 a) { return length(a); }
#endif

// `off`: error bound of z, in world units, the sum of two bounds. One is 1.2e-7 of the point's coordinates, one step of a float, since the
// point was rounded to floats. The other is 6e-7 of the point's distance from the view, five such steps: for the offset from the view and
// for the rasterizer's z. Twin: maps::opaque::rounding.
float stored_depth(View view, Ray ray, float z) {
    PRECISE vec3 position = ray.origin + z * ray.direction;
    PRECISE vec3 offset = position - view.origin;
    vec3 coordinates = abs(position);
    PRECISE float off = 1.2e-7 * (coordinates.x + coordinates.y + coordinates.z) + 6e-7 * longest3(offset);
    PRECISE float range = view.far - view.near;
    // 4e-6 of the range: error bound for the rounding of a depth near 1.
    PRECISE float depth = (z + off - view.near) * reciprocal(range) + (4e-6 + OPAQUE_STEP);
    return depth;
}
#endif
