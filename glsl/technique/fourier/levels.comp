#version 460
// Builds levels of detail of Fourier series, of the mean transmittance of the four texels below each.
// Inputs: maps, words of the level below. Output: words of the levels. Twin: reference::twin::texel_sums::Curve.
// Invariant: as maps/sums/levels.glsl.
#include "maps/sums/level_words.glsl"
#include "technique/fourier/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "technique/fourier/read.glsl"
#include "maps/sums/even_cells.glsl"
#include "maps/sums/levels.glsl"
