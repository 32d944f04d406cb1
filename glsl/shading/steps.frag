#version 460
// Counts the steps of the look-ups at a point of a surface, over all lights. Inputs: lights, camera, the technique.
// Output: the count. A technique that counts has `#ifdef LOOK_UP_STEPS` in its look-up and adds to look_up_steps there.
#include "shading/shading.glsl"
#include "shading/surface.glsl"
#define LOOK_UP_STEPS
uint look_up_steps = 0u;
#include "visibility.glsl"
#include "shading/picture_set.glsl"
#include "query/receiver.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA

layout(location = 0) flat in vec3 corner;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec3 albedo;
layout(location = 3) flat in vec2 z_range;
layout(location = 4) flat in uint is_closed;
layout(location = 0) out float steps;

void main() {
    Ray ray = surface_ray(camera, gl_FragCoord.xy);
    vec3 position = surface_position(ray, surface_z(ray, Surface(corner, normal, z_range)));
    for (uint i = 0u; i < lights.length(); ++i) {
        surface_visibility(i, lights[i], position, normal, is_closed != 0u);
    }
    steps = float(look_up_steps);
}
