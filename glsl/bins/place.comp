#version 460
// Gives each tile of a map its place among the entries, in any order: tiles do not depend on each other. Lists the tiles
// that have casters (all where EVERY is 1) and how many workgroups they take.
// Inputs: counts. Outputs: offsets, cursors (a copy that scatter advances), tiles in use, totals (cleared before).
#include "bins/totals.glsl"

layout(local_size_x = 64) in;

// Workgroups a tile.
layout(constant_id = 4) const uint PARTS = 1u;
// 1: tiles without casters are listed too.
layout(constant_id = 3) const uint EVERY = 0u;

layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 1, scalar) writeonly buffer Offsets { uint offsets[]; };
layout(set = 1, binding = 2, scalar) writeonly buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 3, scalar) buffer Totals { BinTotals totals[]; };
layout(set = 1, binding = 7, scalar) writeonly buffer InUse { uint tiles_in_use[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uint tile_total;  // of a map
};

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile == 0u) {
        totals[map].groups_x = BIN_GROUPS_X;
        totals[map].groups_z = PARTS;
    }
    if (tile >= tile_total) {
        return;
    }
    uint count = counts[map * tile_total + tile];
    if (count > 0u) {
        uint offset = atomicAdd(totals[map].entries, count);
        offsets[tile] = offset;
        cursors[tile] = offset;
        atomicAdd(totals[map].tiles_used, 1u);
    }
    if (count > 0u || EVERY == 1u) {
        uint place = atomicAdd(totals[map].tiles_listed, 1u);
        tiles_in_use[place] = tile;
        atomicMax(totals[map].groups_y, place / BIN_GROUPS_X + 1u);
    }
}
