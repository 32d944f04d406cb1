#version 460
// shadows=queued, third of three passes: one thread per job, regardless of its pixel. Inputs: jobs, lights, normal, z, the technique.
// Output: bits of shadows.
#extension GL_EXT_samplerless_texture_functions : require
#include "visibility.glsl"
#include "shading/many_lights/answer.glsl"
#include "shading/many_lights/queue.glsl"

layout(local_size_x = 64) in;

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint index = group * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
    if (index >= queue.jobs) {
        return;
    }
    uint job = jobs[index], pixel = job >> light_bits, light = job & ((1u << light_bits) - 1u);
    if (is_shadowed(seen(uvec2(pixel % size.x, pixel / size.x)), light)) {
        atomicOr(shadows[shadow_word(pixel, light / 32u)], 1u << (light % 32u));
    }
}
