#version 460
// Composites casters that were painted from near to far over the picture of the meshes. Inputs: seen, premultiplied. Output: colors.
// Twin: reference::twin::half_angle.
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: painter_behind
layout(set = 0, binding = 0) uniform texture2D seen;
layout(set = 0, binding = 1, rgba32f) uniform image2D colors;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(colors)))) {
        return;
    }
    vec4 front = texelFetch(seen, pixel, 0), behind = imageLoad(colors, pixel);
    imageStore(colors, pixel, vec4(front.rgb + (1.0 - front.a) * behind.rgb, behind.a));
}
