// Layout of the texels of levels of detail in memory: first the texels of level 0 of all maps, then the texels of level 1 of all maps, and
// so on. A level has half as many texels per side as the previous level, rounded up. Twin: maps::levels.
#ifndef MAPS_LEVEL_PLACE_GLSL
#define MAPS_LEVEL_PLACE_GLSL

CONSTANT(uint, LEVELS, 1u)  // number of levels of detail, including the map itself

// Texels per side of a level; `size`: texels per side of the map.
uvec2 level_size(uvec2 size, uint level) { return (size + (1u << level) - 1u) >> level; }

// Number of texels of all `maps` maps that come before those of a level.
uint level_first(uvec2 size, uint maps, uint level) {
    uint first = 0u;
    for (uint i = 0u; i < level; ++i) {
        uvec2 its = level_size(size, i);
        first += its.x * its.y * maps;
    }
    return first;
}
#endif
