#version 460
// Counts the casters of each tile of each map. A caster that meets no tile, because it lies outside the light's volume or in
// the dark behind the meshes, is culled: nothing is drawn or binned of it.
// Inputs: maps, casters, horizon. Outputs: counts, met (both cleared before).
#include "bins/tiles.glsl"
#include "bins/totals.glsl"

layout(local_size_x = BIN_THREADS) in;

layout(set = 1, binding = 0, scalar) buffer Counts { uint counts[]; };
layout(set = 1, binding = 5, scalar) buffer Met { uint met[]; };
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
    bool any = false;
    for (uint i = lane; i < size.x * size.y; i += TILE_LANES) {
        uvec2 tile = low + uvec2(i % size.x, i / size.x);
        uint place = (map * tiles.y + tile.y) * tiles.x + tile.x;
        if (!tile_missed(tile_distance(view, caster, tile)) && !tile_hidden(view, caster, horizon[place])) {
            atomicAdd(counts[place], 1u);
            any = true;
        }
    }
    if (any) {
        met[map * caster_count + index] = 1u;
    }
}
