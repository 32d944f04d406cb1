#version 460
// Shades a particle: single scattering, light visibility at the middle of what the camera ray sees of the sphere.
// Inputs: light, camera, particles, z of the meshes, the technique. Output: premultiplied colour, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "common/particle.glsl"
#include "common/shading.glsl"
#include "visibility.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 0, binding = 3, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 2, binding = 0) uniform texture2D distances;

layout(location = 0) flat in uint particle_index;
layout(location = 0) out vec4 color;

void main() {
    Particle particle = particles[particle_index];
    Ray ray = view_ray(camera, gl_FragCoord.xy);
    vec2 z;
    bool hit = particle_overlap(ray, particle, z);
    z.x = max(z.x, camera.near);
    z.y = min(z.y, texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r);
    if (!hit || z.y <= z.x) {
        discard;
    }
    float opacity = 1.0 - exp(-particle_optical_depth(ray, particle, z));
    vec3 position = ray.origin + 0.5 * (z.x + z.y) * ray.direction;
    float visibility = light_visibility(0u, position);
    color = vec4(shade_particle(lights[0], position, visibility) * opacity, opacity);
}
