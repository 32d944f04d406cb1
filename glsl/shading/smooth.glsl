// A triangle's normal, smoothed over its corners, for display, not for measured pictures. Twin: reference::truth::shown.
#ifndef CONSUME_SMOOTH_GLSL
#define CONSUME_SMOOTH_GLSL
#include "world/triangle.glsl"

// Interpolates the corners' normals at a point of the triangle; the result is on the same side as `normal`.
vec3 smooth_normal(Triangle triangle, vec3 corners[3], vec3 position, vec3 normal) {
    // Barycentric weights, unnormalized: areas of the triangles between the point and each side, projected along the normal.
    vec3 to[3] = vec3[3](triangle.corners[0] - position, triangle.corners[1] - position, triangle.corners[2] - position);
    vec3 across = cross(to[1] - to[0], to[2] - to[0]);
    vec3 shares = max(vec3(dot(cross(to[1], to[2]), across), dot(cross(to[2], to[0]), across),
                           dot(cross(to[0], to[1]), across)), vec3(0.0));
    vec3 mixed = shares.x * corners[0] + shares.y * corners[1] + shares.z * corners[2];
    float side = dot(mixed, normal);
    return side == 0.0 ? normal : normalize(side < 0.0 ? -mixed : mixed);
}
#endif
