#version 460
// Counts the casters of each tile of a map. A caster that meets no tile, because it lies outside the light's volume or in
// the dark behind the meshes, is culled: nothing is drawn or binned of it.
// Inputs: map, casters, horizon. Outputs: counts, met (both cleared before).
#include "bins/tiles.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 0, scalar) buffer Counts { uint counts[]; };
layout(set = 1, binding = 5, scalar) buffer Met { uint met[]; };
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
