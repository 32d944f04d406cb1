#version 460
// Adds fog in front of the picture, one thread per pixel. Inputs: lights, camera, z of the meshes, the technique. Output: colors. Twin:
// reference::truth::fog.
#include "shading/painter/picture.glsl"
#include "shading/picture_set.glsl"
#include "world/light.glsl"
#include "visibility.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PAINTED_DISTANCES
PAINTED_COLORS

#include "shading/fog.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, uvec2(camera.width, camera.height)))) {
        return;
    }
    vec4 fog = fog_at(pixel, texelFetch(distances, ivec2(pixel), 0).r), behind = imageLoad(colors, ivec2(pixel));
    imageStore(colors, ivec2(pixel), vec4(fog.rgb + (1.0 - fog.a) * behind.rgb, behind.a));
}
