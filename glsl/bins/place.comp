#version 460
// Gives each tile of a map its place among the entries, in any order: tiles do not depend on each other. Lists the parts
// into which tiles are cut, one a workgroup: PARTS of a tile that has casters, EMPTY_PARTS of one that has none.
// Inputs: counts. Outputs: cursors, where scatter begins to write, parts, totals (cleared before).
#include "bins/totals.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 3) const uint PARTS = 1u;
layout(constant_id = 4) const uint EMPTY_PARTS = 0u;

layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 1, scalar) writeonly buffer Parts { TilePart parts[]; };
layout(set = 1, binding = 2, scalar) writeonly buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 3, scalar) buffer Totals { BinTotals totals[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uint tile_total;  // of a map
    uint capacity;    // of the entries
};

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile == 0u) {
        totals[map].groups_x = BIN_GROUPS_X;
        totals[map].groups_z = 1u;
    }
    if (tile >= tile_total) {
        return;
    }
    uint count = counts[map * tile_total + tile], first = 0u;
    if (count > 0u) {
        first = atomicAdd(totals[map].entries, count);
        cursors[tile] = first;
        atomicAdd(totals[map].tiles_used, 1u);
    }
    // Where the entries are too few, which is found out and mended after the build, nobody reads past them.
    uint readable = first < capacity ? min(count, capacity - first) : 0u;
    uint wanted = count > 0u ? PARTS : EMPTY_PARTS;
    if (wanted > 0u) {
        uint place = atomicAdd(totals[map].parts, wanted);
        for (uint i = 0u; i < wanted; ++i) {
            parts[place + i] = TilePart(tile, i, first, readable);
        }
        atomicMax(totals[map].groups_y, (place + wanted - 1u) / BIN_GROUPS_X + 1u);
    }
}
