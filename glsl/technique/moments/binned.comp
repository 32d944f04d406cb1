#version 460
// Computes the moments of the optical depth of each texel's casters over its range. Source: Münstermann, Krumpen, Klein and Peters 2018,
// Moment-Based Order-Independent Transparency; building them from tiles, with integer sums, exact segments, a range per texel and Chebyshev
// polynomials instead of powers, is ours. Inputs: maps, casters, parts, entries. Output: words. Twin: reference::twin::moments. Invariant:
// as in maps/sums/binned.glsl.
#include "technique/moments/store.glsl"
#include "maps/sums/binned.glsl"
