#version 460
// Assigns each tile of each map its range of entries, in any order: tiles do not depend on each other. If every tile has the same capacity,
// its range is fixed and its entries are already written. Lists the parts into which tiles are split, one per workgroup: PARTS for a tile
// with casters, EMPTY_PARTS for a tile without. With DETAIL the shader does the same for blocks instead of tiles; only blocks that have a
// place are built. Inputs: counts, slots. Outputs: cursors, where scatter begins to write, parts, totals (cleared beforehand).
#include "maps/bins/place.glsl"

layout(local_size_x = BIN_THREADS) in;

void main() {
    uint map = gl_WorkGroupID.z, tile = map_thread(), per_map = bins_per_map(), bin = map * per_map + tile;
    if (tile == 0u && map == 0u) {
        totals[0].groups_x = BIN_GROUPS_X;
        totals[0].groups_z = 1u;
    }
    if (tile >= per_map) {
        return;
    }
    uint count = counts[bin], first = 0u;
    if (count > 0u) {
        first = atomicAdd(totals[0].entries, count);
        if (first + count < first) {
            atomicAdd(totals[0].entries_high, 1u);
        }
        atomicAdd(totals[0].tiles_used, 1u);
        atomicMax(totals[0].fullest, count);
    }
    first = first_entry(bin, DETAIL ? slot_place(slots[bin]) - 1u : bin, count, first);
    uint wanted = parts_wanted(bin, count);
    if (wanted > 0u) {
        uint place = atomicAdd(totals[0].parts, wanted);
        list_parts(place, wanted, bin, count, first);
        atomicMax(totals[0].groups_y, (place + wanted - 1u) / BIN_GROUPS_X + 1u);
    }
}
