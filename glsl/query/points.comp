#version 460
// Queries the technique for the visibility of one light, at a range of the points in a list, or over squares around them. Inputs: points, a
// light, the technique. Output: one number per point, for one color channel.
#include "world/view.glsl"
#include "visibility.glsl"
#include "query/colored.glsl"
#include "query/receiver.glsl"

layout(local_size_x = 64) in;

// set 0: query
layout(set = 0, binding = 0, scalar) readonly buffer Points { vec3 points[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Answers { float answers[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Normals { vec3 all_normals[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Sides { float sides[]; };

layout(push_constant, scalar) uniform QueryPush {
    uint light;
    uint first;
    uint count;
    uint normals;
    uint areas;
};

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
    if (index < count) {
        index += first;
        vec3 position = points[index];
        if (areas > 0u) {
            light_footprint(sides[index]);
        }
        // A normal of 0 marks a surface that faces away from the light.
        bool away = false;
        if (normals > 0u) {
            away = all_normals[index] == vec3(0.0);
            position = light_receiver(light, position, all_normals[index]);
        }
        answers[index] = away ? 0.0 : colored(light_visibility(light, position))[CHANNEL];
    }
}
