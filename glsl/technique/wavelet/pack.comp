#version 460
// Packs the means of Haar wavelets that raster.frag drew. Inputs: ends, sums. Output: words. Twin: reference::twin::wavelet.
#include "technique/wavelet/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "maps/sums/pack.glsl"
