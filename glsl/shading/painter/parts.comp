#version 460
// Splits the list of each tile into parts of nearly equal length. The order in which tiles are listed is left to chance, and does not
// change the picture. Inputs: ranges, totals. Outputs: parts, splits, totals. Twin: reference::twin::painter.
#include "shading/painter/list_set.glsl"

layout(local_size_x = LIST_THREADS) in;

LIST_RANGES
LIST_PARTS
LIST_SPLITS
LIST_TOTALS

void main() {
    uint tile = list_group() * LIST_THREADS + gl_LocalInvocationIndex;
    uvec2 tiles = tile_counts();
    if (tile >= tiles.x * tiles.y) {
        return;
    }
    uint entries = ranges[tile].y - ranges[tile].x;
    if (entries == 0u) {
        return;
    }
    uint cut = (entries + totals.part_entries - 1u) / totals.part_entries;
    uint at = atomicAdd(totals.parts, cut), slot = NO_SLOT;
    atomicMax(totals.part_groups[1], (at + cut + PART_GROUPS - 1u) / PART_GROUPS);
    if (cut > 1u) {
        slot = atomicAdd(totals.slots, cut);
        uint split = atomicAdd(totals.split, 1u);
        atomicMax(totals.split_groups[1], split / PART_GROUPS + 1u);
        splits[split] = Part(tile, 0u, cut, slot);
    }
    for (uint i = 0u; i < cut; ++i) {
        parts[at + i] = Part(tile, i, cut, slot);
    }
}
