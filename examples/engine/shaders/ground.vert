#version 460
// The ground: a square in the plane z = 0.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"

layout(location = 0) out vec3 position;

void main() {
    const vec2 corners[6] = { vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1) };
    position = vec3(40.0 * corners[gl_VertexIndex], 0.0);
    gl_Position = frame.clip * vec4(position, 1.0);
}
