#version 460
// Draws particles as the camera sees them, far to near. Six vertices a particle. Inputs: camera, particles, order.
#include "common/particle.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 0, binding = 3, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Order { uint order[]; };

layout(location = 0) flat out uint particle_index;

void main() {
    particle_index = order[gl_VertexIndex / 6];
    gl_Position = particle_corner(camera, particles[particle_index], gl_VertexIndex % 6);
}
