#version 460
#extension GL_ARB_fragment_shader_interlock : require
// Inserts the caster's segment into the texel's curve, one fragment of a texel at a time, in drawing order.
// Source: seed 000 (Pixel Shader Ordering). Inputs: map, casters. In and out: nodes.
// Invariant: `nodes` is coherent, since the interlock orders accesses but does not make writes visible.
#include "avsm/curve.glsl"
#include "list/texel_segment.glsl"

layout(pixel_interlock_ordered) in;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 0, scalar) coherent buffer Nodes { Node nodes[]; };

layout(push_constant, scalar) uniform Push { uint map; };

layout(location = 0) flat in uint caster_index;

void main() {
    View view = maps[map].volume;
    uvec2 texel = uvec2(gl_FragCoord.xy);
    vec2 depth;
    float optical_depth;
    bool hit = texel_segment(view, texel, casters[caster_index], depth, optical_depth);
    // Curves that are to be packed are built in room for one map, which the maps use in turn.
    uint slot = PACKED == 1u ? 0u : map;
    uint first = ((slot * view.height + texel.y) * view.width + texel.x) * NODES;
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
