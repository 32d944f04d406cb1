#version 460
// Draws simulated particles as the camera sees them: one triangle each, parallel to the picture's plane.
// Source: Pestana's GPU particles (2015). Inputs: camera, bodies. Outputs: the particle's centre, its speed, its z.
#extension GL_EXT_scalar_block_layout : require
#include "shading/picture_set.glsl"
#include "world/body.glsl"
#include "world/view.glsl"

PICTURE_CAMERA
// set 2: picture_points
layout(set = 2, binding = 0, scalar) readonly buffer Bodies { Body bodies[]; };

layout(location = 0) flat out vec3 middle;
layout(location = 1) flat out float speed;
layout(location = 2) flat out float z;

// Distance from the centre to a corner, as a multiple of the particle's radius.
CONSTANT(float, POINT_SIZE, 1.0)

const vec2 CORNERS[3] = vec2[3](vec2(0.0, 1.0), vec2(-0.866025, -0.5), vec2(0.866025, -0.5));

void main() {
    Body body = bodies[gl_VertexIndex / 3];
    middle = body.place.xyz;
    speed = length(body.speed.xyz);
    vec2 corner = CORNERS[gl_VertexIndex % 3] * (POINT_SIZE * body.place.w);
    vec3 offset = middle + corner.x * camera.right + corner.y * camera.up - camera.origin;
    z = dot(offset, camera.forward);
    gl_Position = vec4(dot(offset, camera.right) * camera.scale_x, dot(offset, camera.up) * camera.scale_y,
                       (z - camera.near) * camera.far / (camera.far - camera.near), view_w(camera, z));
}
