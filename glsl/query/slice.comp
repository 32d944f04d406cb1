#version 460
// Debug view: visibility at one depth of a map's range, over the whole map. Source: Fife and Strugar 2013, Debug view. Inputs: view, light,
// depth, the technique. Output: one number per pixel, rows from the top.
#include "world/view.glsl"
#include "visibility.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: slice
layout(set = 0, binding = 0, scalar) readonly buffer Views { View view; };
layout(set = 0, binding = 1, scalar) writeonly buffer Answers { float answers[]; };

layout(push_constant, scalar) uniform SlicePush {
    uint light;
    float depth;  // 0 to 1
    uint width;
    uint height;
};

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= width || pixel.y >= height) {
        return;
    }
    vec2 texel = (vec2(pixel) + 0.5) / vec2(width, height) * vec2(view.width, view.height);
    Ray ray = view_ray(view, texel);
    float z = mix(view.near, view.far, depth);
    answers[pixel.y * width + pixel.x] = light_visibility(light, ray.origin + z * ray.direction);
}
