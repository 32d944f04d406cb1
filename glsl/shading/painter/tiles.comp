#version 460
// Finds where each tile's entries begin and end among the sorted ones. Inputs: items, totals. Output: ranges, cleared beforehand.
// Twin: reference::twin::painter.
#include "shading/painter/list_set.glsl"

layout(local_size_x = LIST_THREADS) in;

LIST_ITEMS
LIST_RANGES
LIST_TOTALS

void main() {
    uint begin = list_group() * ENTRY_BLOCK, end = min(begin + ENTRY_BLOCK, totals.entries);
    for (uint e = begin + gl_LocalInvocationIndex; e < end; e += LIST_THREADS) {
        uint tile = items[sorted + e].key;
        if (e == 0u || items[sorted + e - 1u].key != tile) {
            ranges[tile].x = e;
        }
        if (e + 1u == totals.entries || items[sorted + e + 1u].key != tile) {
            ranges[tile].y = e + 1u;
        }
    }
}
