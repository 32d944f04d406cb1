#version 460
// The debug view: visibility at one depth of the light's range, over the light's view. Source: seed 000 (debug view).
// Inputs: light, depth, the technique. Output: one number a pixel, rows from the top.
#include "common/light.glsl"
#include "visibility.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Answers { float answers[]; };

layout(push_constant, scalar) uniform Push {
    float depth;  // 0 to 1
    uint width;
    uint height;
};

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= width || pixel.y >= height) {
        return;
    }
    View view = lights[0].volume;
    vec2 texel = (vec2(pixel) + 0.5) / vec2(width, height) * vec2(view.width, view.height);
    Ray ray = view_ray(view, texel);
    float z = mix(view.near, view.far, depth);
    answers[pixel.y * width + pixel.x] = light_visibility(0u, ray.origin + z * ray.direction);
}
