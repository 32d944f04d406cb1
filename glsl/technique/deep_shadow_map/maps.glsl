// Shared by the passes that make deep shadow maps. Twins: technique::deep_shadow_map, DeepPush and DeepState.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_MAPS_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_MAPS_GLSL
#include "maps/list/segments.glsl"
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform DeepPush {
    uint first_map;      // the first of the maps whose lists exist at the same time
    uint map_count;      // how many these maps are
    uint group;          // which of the groups of such maps
    uint segment_room;   // segments that the lists have room for
    uint node_room;      // nodes that there is room for
    uint round;          // of the search for an error
    float node_error;    // the error that nodes stay within; 0: the error that the search has found
    uint stored_words;   // of a node
    uint is_written;     // 1: nodes are written, 0: counted
};

// Totals over all maps' nodes.
struct DeepState {
    uint nodes;    // of the groups so far
    uint covered;  // texels that have some
    float error;   // that is tried, or that was found at last
    float low;     // low: an error that is too small; high: one that is not
    float high;
};

// Tiles of 8×8 texels across and down a map.
uvec2 map_tiles() { return (map_size() + 7u) / 8u; }

// The workgroup's tile among those of all maps.
uint group_tile() {
    uvec2 tiles = map_tiles();
    return ((first_map + gl_WorkGroupID.z) * tiles.y + gl_WorkGroupID.y) * tiles.x + gl_WorkGroupID.x;
}
#endif
