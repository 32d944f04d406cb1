#version 460
#extension GL_ARB_fragment_shader_interlock : require
// Inserts the particle's segment into the texel's curve, one fragment of a texel at a time, in drawing order.
// Source: seed 000 (Pixel Shader Ordering). Inputs: light, particles. In and out: nodes.
// Invariant: `nodes` is coherent, since the interlock orders accesses but does not make writes visible.
#include "avsm/curve.glsl"
#include "list/texel_segment.glsl"

layout(pixel_interlock_ordered) in;

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 1, binding = 0, scalar) coherent buffer Nodes { Node nodes[]; };

layout(location = 0) flat in uint particle_index;

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy);
    vec2 depth;
    float optical_depth;
    bool hit = texel_segment(lights[0].volume, texel, particles[particle_index], depth, optical_depth);
    uint first = (texel.y * lights[0].volume.width + texel.x) * NODES;
    beginInvocationInterlockARB();
    if (hit) {
        curve_clear();
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            curve_load(i, nodes[first + i]);
        }
        curve_insert(depth.x, depth.y, optical_depth);
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            nodes[first + i] = curve_node(i);
        }
    }
    endInvocationInterlockARB();
}
