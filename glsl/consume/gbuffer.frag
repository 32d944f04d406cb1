#version 460
// First half of deferred shading. Inputs: camera. Outputs: albedo, normal and whether it is the outside of something closed, z.
#include "consume/picture_set.glsl"
#include "consume/surface.glsl"

PICTURE_CAMERA

layout(location = 0) flat in vec3 corner;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec3 albedo;
layout(location = 3) flat in vec2 z_range;
layout(location = 4) flat in uint is_closed;
layout(location = 0) out vec4 out_albedo;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out float z;

void main() {
    out_albedo = vec4(albedo, 1.0);
    out_normal = vec4(normal, float(is_closed));
    z = surface_z(surface_ray(camera, gl_FragCoord.xy), Surface(corner, normal, z_range));
}
