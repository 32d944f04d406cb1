#version 460
#extension GL_ARB_fragment_shader_interlock : require
// Inserts the caster's segment into the texel's curve, one fragment of a texel at a time, in drawing order.
// Source: Fife and Strugar 2013, Pixel Shader Ordering. Inputs: maps, casters. In and out: nodes.
// Invariant: `nodes` is coherent, since the interlock orders accesses but does not make writes visible.
#define SPLAT_FRAGMENT
#include "avsm/curve.glsl"
#include "maps/scene.glsl"
#include "maps/segment.glsl"
#include "maps/splat.glsl"

layout(pixel_interlock_ordered) in;

layout(set = 2, binding = 0, scalar) coherent buffer Nodes { Node nodes[]; };

void main() {
    View view = maps[map].volume;
    uvec2 texel = splat_texel(view);
    vec2 depth;
    float optical_depth;
    bool hit = texel_segment(view, texel, casters[caster_index], depth, optical_depth);
    // Curves that are to be packed are built in room for the maps that are drawn at once.
    uint first = (((PACKED ? slot : map) * view.height + texel.y) * view.width + texel.x) * NODES;
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
