// Marched look-up: how much of light `light` reaches `position`, 0 to 1, from curves that a march through a density grid made. Sources: Salvi et
// al. 2010; Unreal Engine 5, Heterogeneous Volumes.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  curves, map-major, then texel rows, then a texel's curve as maps/curve/node.glsl states it; then the curves
//              of coarser levels, as maps/level_place.glsl says
//   binding 4  in each tile of 8×8 texels, map-major, tile rows, how many rays meet smoke or hair
// Give the specialization constants NODES, TILED and LEVELS the values with which the curves were built; EXPONENTIAL is always true, PACKED
// and TIGHT are always false.
// flat: bindings 192, constants 384: NODES EXPONENTIAL PACKED TIGHT TILED FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#define MAP_TRANSMITTANCE leveled_transmittance
#include "maps/curve/look_up.glsl"
