#version 460
// Marches a volume and blends it over the picture. Inputs: lights, camera, fields, z of the meshes, the technique. Output: premultiplied
// color, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/shading.glsl"
#include "visibility.glsl"
#include "query/receiver.glsl"
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_DISTANCES

#include "shading/volume.glsl"

layout(location = 0) out vec4 color;

void main() {
    if (!march(gl_FragCoord.xy, texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r)) {
        discard;
    }
    color = blended_color(scattered, 1.0 - transmittance);
}
