#version 460
// Draws the listed tiles of large triangles, one workgroup per tile. Inputs: maps, triangles, items. Output: depths.
// Twin: reference::twin::opaque::draw.
// What is stored: see maps/opaque_store.glsl.
// variants: SEEN 0 1 2 3
layout(local_size_x = 64) in;
#include "maps/opaque_draw.glsl"

void main() {
    uint at = gl_WorkGroupID.y * OPAQUE_ITEMS_X + gl_WorkGroupID.x;
    if (at >= min(totals.items, capacity)) {
        return;
    }
    OpaqueItem item = items[at];
    uint map = item.map_share / OPAQUE_MOST_SHARES;
    View view = maps[map].opaque;
    draw_share(view, opaque_map_corner(view, map), see(view, item.triangle), item.map_share % OPAQUE_MOST_SHARES);
}
