#version 460
// Packs the sums of a Fourier series that raster.frag drew. Inputs: ends, sums. Output: words. Twin:
// reference::twin::fourier.
#include "technique/fourier/parts.glsl"
#include "maps/sums/store_halves.glsl"
#include "maps/sums/pack.glsl"
