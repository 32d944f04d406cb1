#version 460
#extension GL_ARB_fragment_shader_interlock : require
// Inserts the caster's segment into the texel's curve, one fragment of a texel at a time, in drawing order. Source: Fife and Strugar 2013,
// Pixel Shader Ordering. Inputs: maps, casters. In and out: nodes. Nodes are read and written in pairs, and the nodes of neighbouring
// texels are adjacent in memory, since a warp waits for every cache line that an access touches. Invariant: `pairs` is coherent, since the
// interlock orders accesses but does not make writes visible.
#define QUADS_FRAGMENT
#include "technique/avsm/interleaved_layout.glsl"
#include "maps/curve/curve.glsl"
#include "maps/caster_quads.glsl"

layout(pixel_interlock_ordered) in;

layout(set = 2, binding = 0, std430) coherent buffer Nodes { vec4 pairs[]; };

void main() {
    View view = maps[map].caster_view;
    uvec2 texel = quad_texel(view);
    vec2 depth;
    float optical_depth;
    if (!quad_segment(view, depth, optical_depth)) {
        discard;  // before the lock, so that no later fragment waits for it
    }
    // Curves that will be packed are first built in a buffer that holds the maps drawn at once.
    uint row = ((PACKED ? slot : map) * view.height + texel.y) * view.width;
    beginInvocationInterlockARB();
    curve_clear();
    [[unroll]] for (int i = 0; i < NODES / 2; ++i) {
        vec4 pair = pairs[pair_place(row, texel.x, view.width, i)];
        curve_load(2 * i, Node(pair.x, pair.y));
        curve_load(2 * i + 1, Node(pair.z, pair.w));
    }
    if (curve_insert(depth.x, depth.y, optical_depth)) {
        [[unroll]] for (int i = 0; i < NODES / 2; ++i) {
            Node even = curve_node(2 * i), odd = curve_node(2 * i + 1);
            pairs[pair_place(row, texel.x, view.width, i)] = vec4(even.depth, even.value, odd.depth, odd.value);
        }
    }
    endInvocationInterlockARB();
}
