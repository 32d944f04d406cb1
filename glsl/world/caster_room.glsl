// Where the casters of each color of light are stored. If casters absorb colors in different ratios, lights and their maps exist once per
// color, and so do casters, each copy with the extinctions for its color. Bound by maps::Maps::colored and query::colored.
#ifndef WORLD_CASTER_ROOM_GLSL
#define WORLD_CASTER_ROOM_GLSL

// Capacity per color, in casters; 0 if all maps see the same casters.
CONSTANT(uint, CASTER_ROOM, 0u)
// Number of maps per color.
CONSTANT(uint, COLOR_MAPS, 1u)

// Index of the first caster that a map sees.
uint map_casters(uint map) { return map / COLOR_MAPS * CASTER_ROOM; }
#endif
