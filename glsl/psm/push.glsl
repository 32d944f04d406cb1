// What draws of casters into slices are pushed, one draw a map. An instance a map would do, but then lavapipe 26.1 fetches
// the map once a lane, and voxelizing takes longer. Twin: technique::psm::raster::VoxelizePush.
#ifndef PSM_PUSH_GLSL
#define PSM_PUSH_GLSL

layout(push_constant, scalar) uniform VoxelizePush {
    uint map;  // of all lights' maps
};
#endif
