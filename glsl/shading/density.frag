#version 460
// Colors a pixel by the number of particles that cover it, as if they were a fluid that is thin where there are few particles. Source: the
// density view of Pestana's GPU particles (2015). Input: counts. Output: premultiplied color, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_scalar_block_layout : require

// set 0: picture_counted
layout(set = 0, binding = 0) uniform texture2D counts;

layout(push_constant, scalar) uniform DensityPush {
    float many;  // number of particles over a pixel at which the density is 1 − 1/e
};

layout(location = 0) out vec4 color;

// Twin: shading::points::DENSITIES.
const vec3 THIN = vec3(0.04, 0.22, 0.50);
const vec3 THICK = vec3(0.93, 0.98, 1.0);

void main() {
    float density = 1.0 - exp(-texelFetch(counts, ivec2(gl_FragCoord.xy), 0).r / many);
    // Opacity rises faster with density than brightness does, so that even a few particles are visible.
    float opacity = 1.0 - (1.0 - density) * (1.0 - density) * (1.0 - density);
    color = vec4(mix(THIN, THICK, density) * opacity, opacity);
}
