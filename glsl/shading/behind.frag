#version 460
// Blends casters that were drawn from near to far over the picture of the meshes. Input: seen, premultiplied. Output: the same color,
// blended over.
#extension GL_EXT_samplerless_texture_functions : require

// set 0: sliced_seen
layout(set = 0, binding = 0) uniform texture2D seen;

layout(location = 0) out vec4 color;

void main() {
    color = texelFetch(seen, ivec2(gl_FragCoord.xy), 0);
}
