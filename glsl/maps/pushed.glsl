// How receivers are kept out of their own shadow: a stored depth is pushed away by what the triangle's plane changes
// over the look-up's reach in each direction and by as much as its z may be off the texel's centre, and by its own
// rounding. All that draws opaque maps includes this. With EXACT to the same bits on every device, else as fast as the
// device divides. Invariant: a plane's stored depth lies behind the plane everywhere within the reach of the texel's
// centre. Twin: reference::twin::opaque::Pushed.
#ifndef MAPS_PUSHED_GLSL
#define MAPS_PUSHED_GLSL
#include "world/view.glsl"

// A divisor is what is divided by; with EXACT it is kept as its inverse. The product of two divisors is one of them.
#ifdef EXACT
#include "maps/exact.glsl"
#define PRECISE precise
float divisor(float b) { return reciprocal(b); }
float over(float a, float divisor) {
    precise float result = a * divisor;
    return result;
}
#else
#define PRECISE
float divisor(float b) { return b; }
float over(float a, float divisor) { return a / divisor; }
float dot3(vec3 a, vec3 b) { return dot(a, b); }
float length3(vec3 a) { return length(a); }
float longest3(vec3 a) { return length(a); }
#endif

// A rasterizer moves corners onto a grid of 2^-subPixelPrecisionBits texels, to the nearest point or to the next: z is
// that of the plane at most so many texels beside the texel's centre, across and down.
CONSTANT(float, SNAP, 0.0625)

// From a texel's centre to the farthest point that is compared with it, texels across and down.
CONSTANT(float, OPAQUE_REACH, 1.0)

// What a depth of the map's format is less than the one written, at most; 0 where that is a rounding.
CONSTANT(float, OPAQUE_STEP, 0.0)

// What a z or a place across may be off, world units: of a point that comes rounded to floats, one step of its
// coordinates; of its offset from the view and of the rasterizer's z, ten. Twin: maps::opaque::rounding.
float rounding(View view, Ray ray, float z) {
    PRECISE vec3 position = ray.origin + z * ray.direction;
    PRECISE vec3 offset = position - view.origin;
    vec3 coordinates = abs(position);
    PRECISE float off = 1.2e-7 * (coordinates.x + coordinates.y + coordinates.z) + 6e-7 * longest3(offset);
    return off;
}

// The plane of a triangle that is drawn.
struct Pushed {
    vec3 normal;
    float across;  // what its distance changes from one texel to the next, in both directions together; at z = 1 in perspective
    float texel;   // divisor: how wide a texel is there, world units
    float range;   // divisor: of depths, world units
};

Pushed pushed_of(View view, vec3 normal) {
    PRECISE vec3 right = view.right * over(2.0, divisor(float(view.width) * view.scale_x));
    PRECISE vec3 up = view.up * over(2.0, divisor(float(view.height) * view.scale_y));
    PRECISE float across = abs(dot3(normal, right)) + abs(dot3(normal, up));
    PRECISE float range = view.far - view.near;
    float texel = divisor(min(length3(right), length3(up)));
    return Pushed(normal, across, texel, divisor(range));
}

// What is stored of a plane that the ray through a texel's centre meets at z, which is `z_divisor` as a divisor.
float pushed_depth(View view, Pushed plane, Ray ray, float z, float z_divisor) {
    float facing = abs(dot3(plane.normal, ray.direction));
    float off = rounding(view, ray, z);
    // The plane's z a reach on from the centre, where it is farthest: along parallel rays z is linear in the texel,
    // along rays from a point its reciprocal is, in proportion to the plane's facing there. Past the horizon of the
    // plane, infinity.
    PRECISE float texel = plane.texel * (view.projection == VIEW_PARALLEL ? 1.0 : z_divisor);
    PRECISE float reach = (OPAQUE_REACH + over(off, texel)) * plane.across;
    PRECISE float farthest = view.far;
    if (view.projection == VIEW_PARALLEL) {
        farthest = z + over(reach + SNAP * plane.across, divisor(facing));
    } else if (facing > reach) {
        PRECISE float beyond = facing - reach;
        farthest = over(z * (facing + SNAP * plane.across), divisor(beyond));
    }
    // 4e-6 of the range: the rounding of a depth near 1.
    PRECISE float depth = over(farthest + off - view.near, plane.range) + (4e-6 + OPAQUE_STEP);
    return depth;
}
#endif
