#version 460
// Replaces the triangles' normals in the G-buffer by smooth ones, for pictures to look at, not for measured ones.
// Inputs: camera, triangles, numbers, z, normals of triangles' corners. Output: the G-buffer's normals; their fourth
// component stays. Twin: reference::truth::shown.
#extension GL_EXT_samplerless_texture_functions : require
#include "consume/camera_push.glsl"
#include "consume/picture_set.glsl"
#include "consume/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

PICTURE_TRIANGLES
// set 1: picture_smooth
layout(set = 1, binding = 0) uniform utexture2D numbers;
layout(set = 1, binding = 1) uniform texture2D distances;
layout(set = 1, binding = 2, rgba32f) uniform image2D normals;
layout(set = 1, binding = 3, scalar) readonly buffer Corners { vec3 corners[]; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(size)))) {
        return;
    }
    uint number = texelFetch(numbers, pixel, 0).r;
    if (number == 0u) {
        return;
    }
    View camera = pushed_camera();
    float z = texelFetch(distances, pixel, 0).r;
    vec3 position = surface_position(surface_ray(camera, vec2(pixel) + 0.5), z);
    Triangle triangle = triangles[number - 1u];
    // Areas of the triangles between the point and each side, seen along the normal.
    vec3 to[3] = vec3[3](triangle.corners[0] - position, triangle.corners[1] - position, triangle.corners[2] - position);
    vec3 across = cross(to[1] - to[0], to[2] - to[0]);
    vec3 shares = max(vec3(dot(cross(to[1], to[2]), across), dot(cross(to[2], to[0]), across),
                           dot(cross(to[0], to[1]), across)), vec3(0.0));
    uint first = 3u * (number - 1u);
    vec3 mixed = shares.x * corners[first] + shares.y * corners[first + 1u] + shares.z * corners[first + 2u];
    vec4 normal = imageLoad(normals, pixel);
    float side = dot(mixed, normal.xyz);
    if (side != 0.0) {
        imageStore(normals, pixel, vec4(normalize(side < 0.0 ? -mixed : mixed), normal.w));
    }
}
