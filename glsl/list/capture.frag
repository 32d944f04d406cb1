#version 460
// Pushes the particle's segment at the head of the texel's list. Source: seed 000 (capturing fragments).
// Inputs: light, particles. Outputs: heads, segments, the count of fragments.
// Invariant: `fragments` counts the whole demand, also past the capacity, so that the caller can grow the buffer.
#include "list/segments.glsl"
#include "list/texel_segment.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 1, binding = 0, r32ui) uniform uimage2D heads;
layout(set = 1, binding = 1, scalar) writeonly buffer Segments { Segment segments[]; };
layout(set = 1, binding = 2, scalar) buffer Counters { uint fragments; };

layout(push_constant, scalar) uniform Push { uint capacity; };

layout(location = 0) flat in uint particle_index;

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy);
    vec2 depth;
    float optical_depth;
    if (!texel_segment(lights[0].volume, texel, particles[particle_index], depth, optical_depth)) {
        return;
    }
    uint index = atomicAdd(fragments, 1u);
    if (index < capacity) {
        uint next = imageAtomicExchange(heads, ivec2(texel), index);
        segments[index] = Segment(depth.x, depth.y, optical_depth, particle_index, next);
    }
}
