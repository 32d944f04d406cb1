#version 460
// Writes (key, caster) of each caster into each of its tiles, in any order: whoever reads a tile sorts it or needs no
// order, and no two entries of a tile are equal. Inputs: maps, casters, cursors, horizon. Outputs: entries.
#include "bins/tiles.glsl"
#include "bins/totals.glsl"

layout(local_size_x = BIN_THREADS) in;

layout(set = 1, binding = 2, scalar) buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 4, scalar) writeonly buffer Entries { uvec2 entries[]; };
layout(set = 1, binding = 6, scalar) readonly buffer Horizon { float horizon[]; };

void main() {
    uint map = gl_WorkGroupID.z, index = map_thread() / TILE_LANES, lane = map_thread() % TILE_LANES;
    uvec2 low, high;
    if (index >= caster_count || !caster_tiles(maps[map].volume, casters[index], low, high)) {
        return;
    }
    View view = maps[map].volume;
    Caster caster = casters[index];
    uvec2 tiles = tile_counts(view), size = high - low + 1u;
    for (uint i = lane; i < size.x * size.y; i += TILE_LANES) {
        uvec2 tile = low + uvec2(i % size.x, i / size.x);
        uint place = (map * tiles.y + tile.y) * tiles.x + tile.x;
        float distance_square = tile_distance(view, caster, tile);
        if (!tile_missed(distance_square) && !tile_hidden(view, caster, horizon[place])) {
            uint slot = atomicAdd(cursors[place], 1u);
            if (slot < capacity) {
                entries[slot] = uvec2(tile_key(view, caster, tile, distance_square), index);
            }
        }
    }
}
