// Marched look-up: how much of light `light` reaches `position`, 0 to 1, from curves built by a march through a density grid. Sources:
// Salvi et al. 2010; Unreal Engine 5, Heterogeneous Volumes.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  curves, map by map in rows of texels, each as in maps/curve/node.glsl; then the curves of coarser levels, as in
//              maps/level_place.glsl
//   binding 4  number of rays that hit smoke or hair in each tile of 8×8 texels, map by map in rows of tiles
// Set the specialization constants NODES, TILED and LEVELS to the values that the curves were built with; EXPONENTIAL is always true,
// PACKED and TIGHT are always false.
// flat: bindings 192, constants 384: NODES EXPONENTIAL PACKED TIGHT TILED FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#define MAP_TRANSMITTANCE leveled_transmittance
#include "maps/curve/look_up.glsl"
