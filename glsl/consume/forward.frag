#version 460
// Shades the meshes in the pass that draws them. Inputs: light, camera, the technique. Outputs: colour, z.
#include "common/shading.glsl"
#include "visibility.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };

layout(location = 0) in vec3 position;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec3 albedo;
layout(location = 0) out vec4 color;
layout(location = 1) out float z;

void main() {
    float visibility = light_visibility(0u, position);
    color = vec4(shade_surface(lights[0], position, normal, albedo, visibility), 1.0);
    z = dot(position - camera.origin, camera.forward);
}
