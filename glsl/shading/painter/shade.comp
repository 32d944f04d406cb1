#version 460
// Shades the mesh that each pixel sees, from the number of its triangle, one thread per pixel: the work of gbuffer.comp and deferred.frag
// in one pass. Source: Burns and Hunt 2013, The visibility buffer. Inputs: lights, camera, triangles, their sides, numbers, the technique;
// for display, normals of triangles' corners. Outputs: colors, z.
#include "shading/picture_set.glsl"
#include "shading/shading.glsl"
#include "shading/smooth.glsl"
#include "shading/surface.glsl"
#include "visibility.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_TRIANGLES
PICTURE_SIDES

#include "shading/ambient.glsl"
#include "shading/surface_light.glsl"

// set 2: painter_shaded
layout(set = 2, binding = 0, scalar) readonly buffer SeenPixels { uint seen[]; };
layout(set = 2, binding = 1, scalar) readonly buffer Corners { vec3 corners[]; };
layout(set = 2, binding = 2, rgba32f) writeonly uniform image2D colors;
layout(set = 2, binding = 3, r32f) writeonly uniform image2D distances;

layout(push_constant, scalar) uniform ShadePush {
    vec3 sky;
    uint is_smooth;  // not 0: the normals of corners are interpolated
};

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(camera.width, camera.height)))) {
        return;
    }
    uint number = seen[2u * (uint(pixel.y) * camera.width + uint(pixel.x))];
    if (number == 0xFFFFFFFFu) {
        imageStore(colors, pixel, vec4(sky, 1.0));
        imageStore(distances, pixel, vec4(camera.far));
        return;
    }
    Triangle triangle = triangles[number];
    int side = sides[number];
    Surface surface = surface_of(camera, triangle, side);
    Ray ray = surface_ray(camera, vec2(pixel) + 0.5);
    float z = surface_z(ray, surface);
    vec3 position = surface_position(ray, z), normal = surface.normal;
    if (is_smooth != 0u) {
        uint first = 3u * number;
        normal = smooth_normal(triangle, vec3[3](corners[first], corners[first + 1u], corners[first + 2u]), position, normal);
    }
    light_footprint(pixel_side(camera, z));
    vec3 light = ambient();
    for (uint i = 0u; i < lights.length(); ++i) {
        light += surface_light(i, position, normal, side != 0);
    }
    imageStore(colors, pixel, vec4(shade_surface(triangle.albedo, light), 1.0));
    imageStore(distances, pixel, vec4(z));
}
