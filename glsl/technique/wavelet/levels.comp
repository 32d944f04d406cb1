#version 460
// Builds levels of detail of Haar wavelets, stored as means, from the mean transmittance of the four finer texels below each texel. Inputs:
// maps, words of the level below. Output: words of the levels. Twin: reference::twin::texel_sums::Curve. Invariant: as in
// maps/sums/levels.glsl.
#include "maps/sums/level_words.glsl"
#include "technique/wavelet/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "technique/wavelet/read.glsl"
#include "maps/sums/even_cells.glsl"
#include "maps/sums/levels.glsl"
