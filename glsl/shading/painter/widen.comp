#version 460
// Copies a half-float picture to a 32-bit float image, on which compute passes paint. Input: halves. Output: floats.
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: painter_widened
layout(set = 0, binding = 0) uniform texture2D halves;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D floats;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, textureSize(halves, 0)))) {
        imageStore(floats, pixel, texelFetch(halves, pixel, 0));
    }
}
