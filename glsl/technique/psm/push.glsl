// Which map is drawn. Twin: technique::psm::raster::VoxelizePush.
#ifndef TECHNIQUE_PSM_PUSH_GLSL
#define TECHNIQUE_PSM_PUSH_GLSL

layout(push_constant, scalar) uniform VoxelizePush {
    uint pushed_map;  // of all lights' maps
};

// True: there is one draw per map, and the map's number is a push constant. False: there is one draw for all maps, with one instance per
// map. Measured: on lavapipe 26.1 voxelizing takes 1.4 times as long by instances, which fetch the map once per lane; on an H200 1.3 times
// as long by draws.
CONSTANT(bool, MAP_PUSHED, false)

uint drawn_map(uint instance) { return MAP_PUSHED ? pushed_map : instance; }
#endif
