// The descriptor set of the passes that choose the resolution of tiles; these passes also use the set of the bins. A shader declares
// whether it reads or writes each buffer. Bound by maps::Detail.
// set 2: detail
#ifndef MAPS_DETAIL_SET_GLSL
#define MAPS_DETAIL_SET_GLSL
// One survey per tile: map by map, rows of tiles.
#define DETAIL_SURVEYS(access) layout(set = 2, binding = 0, scalar) access Surveys { Survey surveys[]; };
// Number of blocks, then the slot of each block in the order of their places.
#define DETAIL_LISTED(access) layout(set = 2, binding = 1, scalar) access Listed { uint listed[]; };
#endif
