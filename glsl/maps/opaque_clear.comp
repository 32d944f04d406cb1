#version 460
// Clears opaque maps and the list: four texels per thread, one below the other; the workgroup's z is the map. A dispatch instead of a clear
// command: a device may clear images by drawing, which took ten times as long on the H200. Outputs: depths, totals.
layout(local_size_x = 32, local_size_y = 2) in;
#include "maps/opaque_set.glsl"

void main() {
    uint map = first_map + gl_WorkGroupID.z;
    View view = maps[map].opaque;
    ivec2 corner = opaque_map_corner(view, map), size = ivec2(view.width, view.height);
    ivec2 first = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, 4);
    for (int y = first.y; y < min(first.y + 4, size.y) && first.x < size.x; ++y) {
        imageStore(depths, corner + ivec2(first.x, y), uvec4(floatBitsToUint(1.0)));
    }
    if (gl_GlobalInvocationID == uvec3(0u)) {
        totals = OpaqueTotals(0u, OPAQUE_ITEMS_X, 0u, 1u);
    }
}
