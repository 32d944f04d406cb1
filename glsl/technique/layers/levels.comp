#version 460
// Builds a level of detail of all maps: a texel's range is that of the four below it, and at the end of each of its layers it has their
// mean transmittance. What is past the map's edge, or has no casters, lets all light through.
// Inputs: maps, words of the level below. Output: words of the level. Twin: reference::twin::layers.
#include "maps/level_place.glsl"
#include "maps/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: layers_below
// The same buffer as sum_words.
layout(set = 1, binding = 0, scalar) readonly buffer Below { uint below_words[]; };

uint layer_word(uint i) { return below_words[i]; }

#include "technique/layers/read.glsl"
#include "technique/layers/store.glsl"

layout(push_constant, scalar) uniform LevelPush { uint level; };

const uint BELOW = 4u;

void main() {
    uvec2 size = map_size(), below = level_size(size, level - 1u), its = level_size(size, level), texel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(texel, its))) {
        return;
    }
    uint map = gl_WorkGroupID.z, map_count = gl_NumWorkGroups.z, first = level_first(size, map_count, level - 1u);
    uint places[BELOW];
    bool casts[BELOW];
    vec2 ends = vec2(FARTHEST, -FARTHEST);
    for (uint i = 0u; i < BELOW; ++i) {
        uvec2 at = min(2u * texel + uvec2(i & 1u, i >> 1u), below - 1u);
        bool has = at == 2u * texel + uvec2(i & 1u, i >> 1u);
        places[i] = (first + (map * below.y + at.y) * below.x + at.x) * texel_words();
        casts[i] = has && layer_optical_depth(places[i] + range_words(), PLANES) > 0.0;
        vec2 range = layers_range(places[i]);
        ends = casts[i] ? vec2(min(ends.x, range.x), max(ends.y, range.y)) : ends;
    }
    vec2 range = range_of(ends);
    float sums[SUMS];
    for (uint k = 0u; k < SUMS; ++k) {
        float depth = mix(range.x, range.y, layer_end(k + 1u)), mean = 0.0;
        for (uint i = 0u; i < BELOW; ++i) {
            mean += 0.25 * (casts[i] ? layers_transmittance(places[i], depth) : 1.0);
        }
        sums[k] = mean < 1.0 ? min(-log(max(mean, 1e-35)), MAX_OPTICAL_DEPTH) : 0.0;
    }
    store_sums(level_first(size, map_count, level) + (map * its.y + texel.y) * its.x + texel.x, range, sums);
}
