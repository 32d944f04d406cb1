// The descriptor set of the passes that choose how fine tiles are; these passes also use the set of the bins. A shader says for each buffer
// whether it reads or writes it. Bound by maps::Detail.
// set 2: detail
#ifndef MAPS_DETAIL_SET_GLSL
#define MAPS_DETAIL_SET_GLSL
// One per tile: map after map, rows of tiles.
#define DETAIL_SURVEYS(access) layout(set = 2, binding = 0, scalar) access Surveys { Survey surveys[]; };
// How many blocks there are, then the slots of each in the order of their places.
#define DETAIL_LISTED(access) layout(set = 2, binding = 1, scalar) access Listed { uint listed[]; };
#endif
