// Passes over the maps of a group, a workgroup per tile of 8×8 texels, the map in z. Twin: technique::avsm::GroupPush.
#ifndef TECHNIQUE_AVSM_MAPS_GLSL
#define TECHNIQUE_AVSM_MAPS_GLSL
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform GroupPush { uint first_map; };

uint group_map() { return first_map + gl_WorkGroupID.z; }

// The workgroup's tile among those of all maps.
uint group_tile() {
    return (group_map() * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
}

// The thread's texel among those of all maps, and among those of the group.
uint group_texel(uint map) { return (map * map_size().y + gl_GlobalInvocationID.y) * map_size().x + gl_GlobalInvocationID.x; }
#endif
