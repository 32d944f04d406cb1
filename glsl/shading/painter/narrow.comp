#version 460
// Copies the picture painted by compute passes to a half-float image. Input: floats. Output: halves.
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: painter_narrowed
layout(set = 0, binding = 0) uniform texture2D floats;
layout(set = 0, binding = 1, rgba16f) writeonly uniform image2D halves;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, textureSize(floats, 0)))) {
        imageStore(halves, pixel, texelFetch(floats, pixel, 0));
    }
}
