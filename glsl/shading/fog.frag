#version 460
// Draws fog in front of the picture. Inputs: lights, camera, z of the meshes, the technique. Output: premultiplied color, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"
#include "world/light.glsl"
#include "visibility.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_DISTANCES

#include "shading/fog.glsl"

layout(location = 0) out vec4 color;

void main() {
    color = fog_at(uvec2(gl_FragCoord.xy), texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r);
}
