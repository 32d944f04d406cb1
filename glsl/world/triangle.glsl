// A triangle. Twin: world::TriangleData.
#ifndef WORLD_TRIANGLE_GLSL
#define WORLD_TRIANGLE_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Triangle {
    vec3 corners[3];
    vec3 albedo;
};

vec3 triangle_normal(Triangle triangle) {
    vec3 normal = cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]);
    float length_square = dot(normal, normal);
    return length_square > 0.0 ? normal * inversesqrt(length_square) : vec3(0.0);
}
#endif
