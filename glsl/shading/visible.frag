#version 460
// Writes the number of the triangle that each pixel sees, counted from 1; 0 is the sky. gbuffer.comp derives albedo, normal and z from it,
// once per pixel. Holes and see-through triangles are left out. Source: Burns and Hunt 2013, The visibility buffer. Inputs: the triangle's
// number, camera, triangles. Output: the same number.
#include "shading/camera_push.glsl"
#include "shading/picture_set.glsl"
#include "shading/surface.glsl"

PICTURE_TRIANGLES

#define ALPHA_TRIANGLES triangles
#include "world/alpha.glsl"

layout(location = 0) flat in uint number;
layout(location = 0) out uint seen;

void main() {
    if (alpha_number(number - 1u) != 0u) {
        Triangle triangle = triangles[number - 1u];
        View camera = pushed_camera();
        Ray ray = surface_ray(camera, gl_FragCoord.xy);
        vec3 place = surface_position(ray, surface_z(ray, surface_of(camera, triangle, 0)));
        if (!alpha_blocks(number - 1u, alpha_weights(triangle.corners, place))) {
            discard;
        }
    }
    seen = number;
}
