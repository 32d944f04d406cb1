// The map to draw. Twin: technique::psm::raster::VoxelizePush.
#ifndef TECHNIQUE_PSM_PUSH_GLSL
#define TECHNIQUE_PSM_PUSH_GLSL

layout(push_constant, scalar) uniform VoxelizePush {
    uint pushed_map;  // index among all lights' maps
};

// True: one draw per map, with the map's index as a push constant. False: one draw for all maps, with one instance per map. Measured: on
// lavapipe 26.1 voxelizing takes 1.4 times as long with instances, which fetch the map once per lane; on an H200 it takes 1.3 times as long
// with a draw per map.
CONSTANT(bool, MAP_PUSHED, false)

uint drawn_map(uint instance) { return MAP_PUSHED ? pushed_map : instance; }
#endif
