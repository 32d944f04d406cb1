#version 460
// Adds a caster to the optical depth up to the end of each layer. Sources: as in binned.comp. Inputs: maps, casters, ends. Outputs: sums.
// Twin: reference::twin::layers. Invariant: as in maps/sums/raster.glsl.
// variants: TARGETS 1 2 4 8
#include "technique/layers/parts.glsl"
#include "maps/sums/raster.glsl"
