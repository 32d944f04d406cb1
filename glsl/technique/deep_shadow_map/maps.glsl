// Shared by the passes that build deep shadow maps. Twins: technique::deep_shadow_map, DeepPush and DeepState.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_MAPS_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_MAPS_GLSL
#include "maps/list/segments.glsl"
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform DeepPush {
    uint first_map;      // first map of the group, whose lists exist at the same time
    uint map_count;      // number of maps in the group
    uint group;          // index of the group
    uint segment_room;   // capacity of the lists, in segments
    uint node_room;      // capacity of the buffer, in nodes
    uint round;          // round of the search for an error
    float node_error;    // error bound of the nodes; 0: the error bound that the search has found
    uint stored_words;   // words per node
    uint is_written;     // 1: nodes are written, 0: counted
};

// Totals over the nodes of all maps.
struct DeepState {
    uint nodes;    // number of nodes of the groups so far
    uint covered;  // number of texels that have nodes
    float error;   // error bound being tried, finally the error bound that was found
    float low;     // low: an error bound that is too small; high: one that is large enough
    float high;
};

// Returns the number of tiles of 8×8 texels across and down a map.
uvec2 map_tiles() { return (map_size() + 7u) / 8u; }

// Returns the index of the workgroup's tile among the tiles of all maps.
uint group_tile() {
    uvec2 tiles = map_tiles();
    return ((first_map + gl_WorkGroupID.z) * tiles.y + gl_WorkGroupID.y) * tiles.x + gl_WorkGroupID.x;
}
#endif
