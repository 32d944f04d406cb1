#version 460
// Inserts the caster's segment into the texel's curve, which is stored in color attachments: read as input attachments and written back as
// outputs, one fragment of a texel at a time, in drawing order. Source: Fife and Strugar 2013, Pixel Shader Ordering. Inputs: maps,
// casters. In and out: the attachments. Invariant: the pipeline guarantees the order (VK_EXT_rasterization_order_attachment_access); the
// shader stores nothing to memory.
// variants: ATTACHMENTS 2 4 8
#define QUADS_FRAGMENT
#include "technique/avsm/attachments.glsl"
#include "maps/curve/curve.glsl"
#include "maps/caster_quads.glsl"

#define STORED(i) layout(input_attachment_index = i, set = 2, binding = i) uniform subpassInput stored_##i;
#define INSERTED(i) layout(location = i) out vec4 inserted_##i;
EACH_ATTACHMENT(STORED)
EACH_ATTACHMENT(INSERTED)

void load(int i, vec4 pair) {
    curve_load(2 * i, Node(pair.x, pair.y));
    curve_load(2 * i + 1, Node(pair.z, pair.w));
}

vec4 pair(int i) {
    Node first = curve_node(2 * i), second = curve_node(2 * i + 1);
    return vec4(first.depth, first.value, second.depth, second.value);
}

void main() {
    vec2 depth;
    float optical_depth;
    View view = maps[map].caster_view;
    if (!quad_segment(view, depth, optical_depth)) {
        discard;  // leaves the attachments unchanged
    }
    curve_clear();
#define LOAD(i) load(i, subpassLoad(stored_##i));
    EACH_ATTACHMENT(LOAD)
    if (!curve_insert(depth.x, depth.y, optical_depth)) {
        discard;
    }
#define STORE(i) inserted_##i = pair(i);
    EACH_ATTACHMENT(STORE)
}
