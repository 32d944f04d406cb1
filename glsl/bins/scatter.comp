#version 460
// Writes (key, caster) of each caster into each of its tiles, in any order: whoever reads a tile sorts it or needs no
// order, and no two entries of a tile are equal. Inputs: map, casters, cursors, horizon. Outputs: entries.
#include "bins/tiles.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 2, scalar) buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 4, scalar) writeonly buffer Entries { uvec2 entries[]; };
layout(set = 1, binding = 6, scalar) readonly buffer Horizon { float horizon[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uint caster_count;
    uint capacity;
};

void main() {
    uint index = gl_GlobalInvocationID.x / TILE_LANES, lane = gl_GlobalInvocationID.x % TILE_LANES;
    uvec2 low, high;
    if (index >= caster_count || !caster_tiles(maps[map].volume, casters[index], low, high)) {
        return;
    }
    View view = maps[map].volume;
    Caster caster = casters[index];
    uvec2 tiles = tile_counts(view), size = high - low + 1u;
    for (uint i = lane; i < size.x * size.y; i += TILE_LANES) {
        uvec2 tile = low + uvec2(i % size.x, i / size.x);
        float distance_square = tile_distance(view, caster, tile);
        if (!tile_missed(distance_square) &&
            !tile_hidden(view, caster, horizon[(map * tiles.y + tile.y) * tiles.x + tile.x])) {
            uint slot = atomicAdd(cursors[tile.y * tiles.x + tile.x], 1u);
            if (slot < capacity) {
                entries[slot] = uvec2(tile_key(view, caster, tile, distance_square), index);
            }
        }
    }
}
