#version 460
// Draws the sky where no mesh is visible, and blends it over the ground as the ground fades. Inputs: camera, z of the meshes. Output:
// premultiplied color, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/backdrop.glsl"
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"
#include "world/view.glsl"

PICTURE_CAMERA
PICTURE_DISTANCES

layout(location = 0) out vec4 color;

void main() {
    Ray ray = view_ray(camera, gl_FragCoord.xy);
    float z = texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r;
    float share = z < camera.far ? ground_faded(ray.origin + z * ray.direction) : 1.0;
    if (share == 0.0) {
        discard;
    }
    color = vec4(sky_color(normalize(ray.direction)) * share, share);
}
