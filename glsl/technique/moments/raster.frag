#version 460
// Adds a caster to each moment. Source: as in binned.comp. Inputs: maps, casters, ends. Outputs: sums. Twin: reference::twin::moments.
// Invariant: as in maps/sums/raster.glsl.
// variants: TARGETS 1 2 4 8
#include "technique/moments/parts.glsl"
#include "maps/sums/raster.glsl"
