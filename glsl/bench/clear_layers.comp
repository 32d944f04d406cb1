#version 460
// Clears a volume, one thread per texel. Output: volume.
layout(local_size_x = 8, local_size_y = 8) in;

// set 0: clear_layers
layout(set = 0, binding = 0, r32f) writeonly uniform image3D volume;

void main() { imageStore(volume, ivec3(gl_GlobalInvocationID), vec4(1.0)); }
