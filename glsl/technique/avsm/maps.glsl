// Shared by passes over a group of maps, with one workgroup per tile of 8×8 texels and the map in z. Twin: technique::avsm::GroupPush.
#ifndef TECHNIQUE_AVSM_MAPS_GLSL
#define TECHNIQUE_AVSM_MAPS_GLSL
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform GroupPush { uint first_map; };

uint group_map() { return first_map + gl_WorkGroupID.z; }

// Returns the index of the workgroup's tile among the tiles of all maps.
uint group_tile() {
    return (group_map() * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
}

// Returns the index of the thread's texel in `map`, among the texels of all maps, or of the group if `map` counts within the group.
uint group_texel(uint map) { return (map * map_size().y + gl_GlobalInvocationID.y) * map_size().x + gl_GlobalInvocationID.x; }
#endif
