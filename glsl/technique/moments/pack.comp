#version 460
// Packs the moments that raster.frag drew. Inputs: ends, sums. Output: words. Twin: reference::twin::moments.
#include "technique/moments/store.glsl"
#include "maps/sums/pack.glsl"
