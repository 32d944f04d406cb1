#version 460
// Counts the particles' triangles that cover a pixel in front of the meshes. Inputs: particles, z of the meshes. Output: 1, blended
// additively.
#extension GL_EXT_samplerless_texture_functions : require

// set 2: picture_points
layout(set = 2, binding = 1) uniform texture2D distances;

layout(location = 0) flat in vec3 middle;
layout(location = 1) flat in float speed;
layout(location = 2) flat in float z;
layout(location = 0) out vec4 count;

void main() {
    if (z > texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r) {
        discard;
    }
    count = vec4(1.0);
}
