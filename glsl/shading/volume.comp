#version 460
// Marches a volume and composites it over the picture, one thread per pixel. Inputs: lights, camera, fields, z of the meshes, the
// technique. Output: colors. Twin: reference::truth::picture.
#include "shading/shading.glsl"
#include "visibility.glsl"
#include "query/receiver.glsl"
#include "shading/painter/picture.glsl"
#include "shading/picture_set.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PAINTED_DISTANCES
PAINTED_COLORS

#include "shading/volume.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(camera.width, camera.height))) ||
        !march(vec2(pixel) + 0.5, texelFetch(distances, pixel, 0).r)) {
        return;
    }
    vec4 behind = imageLoad(colors, pixel);
    imageStore(colors, pixel, vec4(scattered + transmittance * behind.rgb, behind.a));
}
