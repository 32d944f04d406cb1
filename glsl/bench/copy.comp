#version 460
// Copies a buffer. Inputs: from. Outputs: to, of the same length.
layout(local_size_x = 128) in;

// set 0: copy
layout(set = 0, binding = 0, std430) readonly buffer From { uvec4 from[]; };
layout(set = 0, binding = 1, std430) writeonly buffer To { uvec4 to[]; };

void main() {
    uint groups = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint i = gl_GlobalInvocationID.x; i < from.length(); i += groups) {
        to[i] = from[i];
    }
}
