#version 460
// Writes depth in the light's range, pushed away by what the triangle's plane changes over the look-up's reach in each
// direction and by as much as the rasterizer may be off the texel's centre, and by its own rounding. Inputs: map, z, the
// triangle's plane. Output: depth.
// Invariant: a plane's stored depth lies behind the plane everywhere within the reach of the texel's centre.
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform MapPush {
    uint map;
    uvec2 corner;  // where it stands
};

// A rasterizer moves corners onto a grid of 2^-subPixelPrecisionBits texels, to the nearest point or to the next: z is
// that of the plane at most so many texels beside the texel's centre, across and down.
CONSTANT(float, SNAP, 0.0625)

// From a texel's centre to the farthest point that is compared with it, texels across and down.
CONSTANT(float, OPAQUE_REACH, 1.0)

// What a depth of the map's format is less than the one written, at most; 0 where that is a rounding.
CONSTANT(float, OPAQUE_STEP, 0.0)

layout(location = 0) in float interpolated_z;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec2 cut;

// What a z or a place across may be off, world units: of a point that comes rounded to floats, one step of its
// coordinates; of its offset from the view and of the rasterizer's z, ten. Twin: maps::opaque::rounding.
float rounding(View view, Ray ray, float z) {
    vec3 position = ray.origin + z * ray.direction;
    vec3 coordinates = abs(position);
    return 1.2e-7 * (coordinates.x + coordinates.y + coordinates.z) + 6e-7 * distance(position, view.origin);
}

void main() {
    View view = maps[map].opaque;
    // From the plane and not by dFdx: lavapipe 22.3 has wrong derivatives where a quad of fragments crosses the triangle's
    // edge, and light leaked in along every edge.
    vec3 right = view.right * (2.0 / (float(view.width) * view.scale_x));
    vec3 up = view.up * (2.0 / (float(view.height) * view.scale_y));
    vec2 at = gl_FragCoord.xy - vec2(corner);
    Ray ray = view_ray(view, at);
    float across = abs(dot(normal, right)) + abs(dot(normal, up));
    float facing = abs(dot(normal, ray.direction));
    // Where a corner is at the eye or behind it, SwiftShader interpolates what it may: the plane has the z too. A sliver's plane is
    // known badly, and its z between those of its corners.
    float z = cut.y > 0.0 ? clamp(cut.x / dot(normal, ray.direction), view.near, cut.y) : interpolated_z;
    float off = rounding(view, ray, z);
    // The plane's z a reach on from the centre, where it is farthest: along parallel rays z is linear in the texel,
    // along rays from a point its reciprocal is, in proportion to the plane's facing there. Past the horizon of the
    // plane, infinity.
    float texel = min(length(right), length(up)) * (view.projection == VIEW_PARALLEL ? 1.0 : z);
    float reach = (OPAQUE_REACH + off / texel) * across;
    float farthest = view.projection == VIEW_PARALLEL ? z + (reach + SNAP * across) / facing
                     : facing > reach                 ? z * (facing + SNAP * across) / (facing - reach)
                                                      : view.far;
    // 4e-6 of the range: the rounding of a depth near 1.
    gl_FragDepth = view_depth(view, farthest + off) + (4e-6 + OPAQUE_STEP);
}
