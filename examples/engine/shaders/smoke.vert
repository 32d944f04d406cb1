#version 460
// A square around each particle, facing the eye: six vertices, no vertex buffer.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
layout(location = 0) out vec2 corner;
layout(location = 1) out vec3 position;
layout(location = 2) flat out vec2 radius_and_extinction;

void main() {
    const vec2 corners[6] = { vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1) };
    Particle p = particles[order[gl_VertexIndex / 6]];
    vec3 forward = normalize(p.position - frame.eye), right = normalize(cross(forward, vec3(0, 0, 1)));
    corner = corners[gl_VertexIndex % 6];
    position = p.position + p.radius * (corner.x * right + corner.y * cross(right, forward));
    radius_and_extinction = vec2(p.radius, p.extinction);
    gl_Position = frame.clip * vec4(position, 1.0);
}
