#version 460
// Computes albedo, normal and depth of each pixel, from the number of the triangle seen by the pixel. Source: Burns and Hunt 2013, The
// visibility buffer. Inputs: camera, triangles, their sides, numbers. Outputs: albedo (alpha 0: sky), normal and whether the surface is the
// outside of a closed mesh, z. Twin: reference::twin::gbuffer.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/camera_push.glsl"
#include "shading/picture_set.glsl"
#include "shading/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

PICTURE_TRIANGLES
PICTURE_SIDES
// set 1: picture_seen
layout(set = 1, binding = 0) uniform utexture2D numbers;
layout(set = 1, binding = 1, rgba32f) writeonly uniform image2D albedos;
layout(set = 1, binding = 2, rgba32f) writeonly uniform image2D normals;
layout(set = 1, binding = 3, r32f) writeonly uniform image2D distances;
layout(set = 1, binding = 4, scalar) readonly buffer SeenPixels { uint seen[]; };

#include "shading/seen_number.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    View camera = pushed_camera();
    if (any(greaterThanEqual(pixel, ivec2(size)))) {
        return;
    }
    uint number = seen_number(pixel, size.x);
    vec4 albedo = vec4(0.0), normal = vec4(0.0);
    float z = camera.far;
    if (number != 0u) {
        Triangle triangle = triangles[number - 1u];
        int side = sides[number - 1u];
        Surface surface = surface_of(camera, triangle, side);
        albedo = vec4(triangle.albedo, 1.0);
        normal = vec4(surface.normal, float(side != 0));
        z = surface_z(surface_ray(camera, vec2(pixel) + 0.5), surface);
    }
    imageStore(albedos, pixel, albedo);
    imageStore(normals, pixel, normal);
    imageStore(distances, pixel, vec4(z));
}
