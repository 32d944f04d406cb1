#version 460
// Draws particles as quads over the light's map, in the order of `order`. Six vertices a particle.
// Inputs: light, particles, order. Outputs: position, particle index. Source: seed 000 (sample particle system).
#include "common/light.glsl"
#include "common/particle.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Order { uint order[]; };

layout(location = 0) flat out uint particle_index;

void main() {
    particle_index = order[gl_VertexIndex / 6];
    gl_Position = particle_corner(lights[0].volume, particles[particle_index], gl_VertexIndex % 6);
}
