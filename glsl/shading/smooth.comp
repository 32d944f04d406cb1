#version 460
// Replaces the triangles' normals in the G-buffer by smooth ones, for display, not for measured pictures. Inputs: camera, triangles,
// numbers, z, normals of triangles' corners. Output: the G-buffer's normals; their fourth component is kept.
// Twin: reference::truth::shown.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/camera_push.glsl"
#include "shading/picture_set.glsl"
#include "shading/smooth.glsl"
#include "shading/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

PICTURE_TRIANGLES
// set 1: picture_smooth
layout(set = 1, binding = 0) uniform utexture2D numbers;
layout(set = 1, binding = 1) uniform texture2D distances;
layout(set = 1, binding = 2, rgba32f) uniform image2D normals;
layout(set = 1, binding = 3, scalar) readonly buffer Corners { vec3 corners[]; };
layout(set = 1, binding = 4, scalar) readonly buffer SeenPixels { uint seen[]; };

#include "shading/seen_number.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(size)))) {
        return;
    }
    uint number = seen_number(pixel, size.x);
    if (number == 0u) {
        return;
    }
    View camera = pushed_camera();
    float z = texelFetch(distances, pixel, 0).r;
    vec3 position = surface_position(surface_ray(camera, vec2(pixel) + 0.5), z);
    Triangle triangle = triangles[number - 1u];
    uint first = 3u * (number - 1u);
    vec4 normal = imageLoad(normals, pixel);
    normal.xyz = smooth_normal(triangle, vec3[3](corners[first], corners[first + 1u], corners[first + 2u]), position, normal.xyz);
    imageStore(normals, pixel, normal);
}
