#version 460
// Packs the optical depths that raster.frag drew. Inputs: ends, sums. Output: words. Twin: reference::twin::layers.
#include "technique/layers/store.glsl"
#include "maps/sums/pack.glsl"
