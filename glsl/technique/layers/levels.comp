#version 460
// Builds levels of detail of layers: at the end of each layer, a texel has the mean transmittance of the four finer texels below it.
// Inputs: maps, words of the level below. Output: words of the levels. Twin: reference::twin::layers. Invariant: as in
// maps/sums/levels.glsl.
#include "maps/sums/level_words.glsl"
#include "technique/layers/store.glsl"
#include "technique/layers/read.glsl"

#define LEVEL_CELLS PLANES
float cell_end(uint k) { return layer_end(k); }
uint cell_at(float place) { return layer_at(place); }

#include "maps/sums/levels.glsl"
