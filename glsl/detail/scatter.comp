#version 460
// As bins/scatter.comp, for blocks.
// Inputs: maps, casters, cursors, horizon, slots. Outputs: entries.
#include "detail/casters.glsl"

layout(local_size_x = BIN_THREADS) in;

layout(set = 1, binding = 2, scalar) buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 4, scalar) writeonly buffer Entries { uvec2 entries[]; };
layout(set = 1, binding = 6, scalar) readonly buffer Horizon { float horizon[]; };
layout(set = 1, binding = 7, scalar) readonly buffer Slots { uint slots[]; };

void main() {
    uint map = gl_WorkGroupID.z, index = map_thread() / TILE_LANES, lane = map_thread() % TILE_LANES;
    uvec2 low, high;
    if (index >= caster_count || !caster_touches(maps[map].volume, casters[index], low, high)) {
        return;
    }
    View view = maps[map].volume;
    Caster caster = casters[index];
    uvec2 tiles = tile_counts(view), size = high - low + 1u;
    for (uint t = 0u; t < size.x * size.y; ++t) {
        uvec2 tile = low + uvec2(t % size.x, t / size.x), first, last;
        uint place = (map * tiles.y + tile.y) * tiles.x + tile.x, side = slot_side(slots[place * SLOTS]);
        View fine = finer(view, side);
        if (tile_hidden(view, caster, horizon[place]) || !caster_tiles(fine, caster, first, last)
            || !within_tile(tile, side, first, last)) {
            continue;
        }
        uvec2 blocks = last - first + 1u;
        for (uint i = lane; i < blocks.x * blocks.y; i += TILE_LANES) {
            uvec2 block = first + uvec2(i % blocks.x, i / blocks.x), within = block - tile * side;
            float distance_square = tile_distance(fine, caster, block);
            if (!tile_missed(distance_square)) {
                uint slot = atomicAdd(cursors[place * SLOTS + within.y * side + within.x], 1u);
                if (slot < capacity) {
                    entries[slot] = uvec2(tile_key(fine, caster, block, distance_square), index);
                }
            }
        }
    }
}
