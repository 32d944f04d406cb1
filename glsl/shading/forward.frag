#version 460
// Shades the meshes in the pass that draws them. Inputs: lights, camera, the technique. Outputs: color, z.
#include "shading/picture_set.glsl"
#include "shading/shading.glsl"
#include "shading/surface.glsl"
#include "visibility.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA

#include "shading/ambient.glsl"
#include "shading/surface_light.glsl"

layout(location = 0) flat in vec3 corner;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec3 albedo;
layout(location = 3) flat in vec2 z_range;
layout(location = 4) flat in uint is_closed;
layout(location = 0) out vec4 color;
layout(location = 1) out float z;

void main() {
    Ray ray = surface_ray(camera, gl_FragCoord.xy);
    z = surface_z(ray, Surface(corner, normal, z_range));
    vec3 position = surface_position(ray, z);
    bool closed = is_closed != 0u;
    light_footprint(pixel_side(camera, z));
    vec3 light = ambient();
    for (uint i = 0u; i < lights.length(); ++i) {
        light += surface_light(i, position, normal, closed);
    }
    color = vec4(shade_surface(albedo, light), 1.0);
}
