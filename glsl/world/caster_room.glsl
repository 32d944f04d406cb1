// Where the casters of a color of light stand. Where casters take colors in different ratios, lights and their maps stand once per color,
// and casters once per color too, each time with the extinctions of that color. Bound by maps::Maps::colored and query::colored.
#ifndef WORLD_CASTER_ROOM_GLSL
#define WORLD_CASTER_ROOM_GLSL

// Casters that there is room for in each color; 0 where all maps see the same casters.
CONSTANT(uint, CASTER_ROOM, 0u)
// Maps of a color.
CONSTANT(uint, COLOR_MAPS, 1u)

// The first of the casters that a map sees.
uint map_casters(uint map) { return map / COLOR_MAPS * CASTER_ROOM; }
#endif
