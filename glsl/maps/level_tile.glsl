// Builds up to LEVELS_A_PASS levels of detail of all maps: a workgroup processes a tile of 8 × 8 texels of the level below `level`. From
// these it builds 4 × 4 texels of `level`, then 2 × 2 texels of the next level, then one texel of the level after. This way fewer passes
// have to wait for one another. A technique includes this file and defines make_level, which all threads call. Inputs: maps, texels of the
// level below. Outputs: texels of the levels.
#ifndef MAPS_LEVEL_TILE_GLSL
#define MAPS_LEVEL_TILE_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/level_place.glsl"
#include "maps/scene.glsl"

layout(local_size_x = 64) in;
const uint LEVEL_THREADS = 64u;

// Twin: maps::levels.
const uint LEVELS_A_PASS = 3u;

layout(push_constant, scalar) uniform LevelPush { uint level; };

// Largest number of texels of a level that a workgroup builds, and number of texels below each.
const uint MADE = 16u;
const uint BELOW = 4u;

// The part of a level that a workgroup builds.
struct LevelTile {
    uint level;
    uint side;          // texels per side, 4, 2 or 1
    uvec2 corner;       // its first texel
    uvec2 size;         // size of the level
    uvec2 below;        // size of the level below
    uint first;         // number of this level's texels before the map's first one
    uint below_first;   // the same number for the level below
};

// Index of a missing texel.
const uint NONE = ~0u;

// Depth at the fraction `along` of a range. For a fraction of 1 the end of the range is returned exactly, however a driver computes mix,
// since the value behind the range depends on it.
float depth_along(vec2 range, float along) { return along >= 1.0 ? range.y : mix(range.x, range.y, along); }

uint tile_texels(LevelTile tile) { return tile.side * tile.side; }

// Index of texel t of the tile among those of all maps and levels; NONE past the map's edge.
uint made_place(LevelTile tile, uint t) {
    uvec2 at = tile.corner + uvec2(t % tile.side, t / tile.side);
    return all(lessThan(at, tile.size)) ? tile.first + at.y * tile.size.x + at.x : NONE;
}

// Index of a texel of the level below, where the tile has twice as many texels per side.
uint below_place(LevelTile tile, uvec2 texel) {
    uvec2 at = 2u * tile.corner + texel;
    return all(lessThan(at, tile.below)) ? tile.below_first + at.y * tile.below.x + at.x : NONE;
}

// Texel i of the four below texel t.
uvec2 below_texel(LevelTile tile, uint t, uint i) {
    return 2u * uvec2(t % tile.side, t / tile.side) + uvec2(i & 1u, i >> 1u);
}

// Builds the texels of a tile. All threads call this, and see each other's writes afterwards.
void make_level(LevelTile tile);

void main() {
    uvec2 size = map_size();
    uint map = gl_WorkGroupID.z, map_count = gl_NumWorkGroups.z;
    [[dont_unroll]] for (uint i = 0u; i < LEVELS_A_PASS && level + i < LEVELS; ++i) {
        uint its = level + i, side = 4u >> i;
        uvec2 at = level_size(size, its), below = level_size(size, its - 1u);
        make_level(LevelTile(its, side, side * gl_WorkGroupID.xy, at, below,
                             level_first(size, map_count, its) + map * at.x * at.y,
                             level_first(size, map_count, its - 1u) + map * below.x * below.y));
        memoryBarrierBuffer();
        barrier();
    }
}
#endif
