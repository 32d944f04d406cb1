#version 460
// Builds a level of detail of all maps: the curve of each texel is the mean transmittance of the four below it, at the depths of all
// of their nodes, compressed. What is past the map's edge, or has no casters, lets all light through.
// Inputs: maps, nodes of the level below, counts. Output: nodes of the level. Twin: reference::twin::avsm::levels.
// Invariant: behind all nodes it is the mean of what the four have there, to what storing rounds.
#include "maps/level_place.glsl"
#include "maps/scene.glsl"
#include "maps/curve/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 1, binding = 0, scalar) buffer Nodes { uvec2 nodes[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

uvec2 curve_pair(uint i) { return nodes[i]; }

// Before the curve that is built: its nodes are stored as pairs.
#include "maps/curve/store.glsl"
#include "maps/curve/curve.glsl"
#include "maps/curve/read.glsl"

layout(push_constant, scalar) uniform LevelPush { uint level; };

const uint BELOW = 4u;

// Each of the four has: where its curve is, its next node, and the nodes about the depth that is looked at.
uint places[BELOW], nexts[BELOW];
vec2 ranges[BELOW];
Node befores[BELOW], aheads[BELOW];

Node next_node(uint i) {
    return nexts[i] < uint(NODES) ? texel_node(places[i], nexts[i], ranges[i]) : Node(EMPTY, befores[i].value);
}

// What texel i of the four has at a depth between its nodes.
float below_at(uint i, float depth) {
    float extent = aheads[i].depth - befores[i].depth;
    float along = aheads[i].depth < EMPTY && extent > 0.0 ? clamp((depth - befores[i].depth) / extent, 0.0, 1.0) : 0.0;
    return nexts[i] == 0u ? 1.0 : curve_transmittance(mix(befores[i].value, aheads[i].value, along));
}

// Optical depth of the mean of the four.
float mean_optical_depth(float depth) {
    float mean = 0.0;
    [[unroll]] for (uint i = 0u; i < BELOW; ++i) {
        mean += 0.25 * below_at(i, depth);
    }
    return mean < 1.0 ? min(-log(max(mean, 1e-35)), MAX_OPTICAL_DEPTH) : 0.0;
}

void main() {
    uvec2 size = map_size(), below = level_size(size, level - 1u), its = level_size(size, level), texel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(texel, its))) {
        return;
    }
    uint map = gl_WorkGroupID.z, map_count = gl_NumWorkGroups.z, first = level_first(size, map_count, level - 1u);
    [[unroll]] for (uint i = 0u; i < BELOW; ++i) {
        uvec2 at = 2u * texel + uvec2(i & 1u, i >> 1u), tiles = (size + 7u) / 8u, tile = at / 8u;
        bool has = all(lessThan(at, below));
        if (has && level == 1u) {
            has = !tile_skipped(counts[(map * tiles.y + tile.y) * tiles.x + tile.x]);
        }
        places[i] = (first + (map * below.y + at.y) * below.x + at.x) * curve_pairs();
        ranges[i] = has ? curve_range(places[i]) : vec2(0.0);
        nexts[i] = 0u;
        befores[i] = Node(EMPTY, curve_unshadowed());
        aheads[i] = Node(EMPTY, curve_unshadowed());
        if (has) {
            aheads[i] = next_node(i);
        }
    }
    curve_clear();
    float last = 0.0;
    [[dont_unroll]] for (uint step = 0u; step < BELOW * uint(NODES) && last < DARK; ++step) {
        float depth = min(min(aheads[0].depth, aheads[1].depth), min(aheads[2].depth, aheads[3].depth));
        if (depth >= EMPTY) {
            break;
        }
        bool done = false;
        [[unroll]] for (uint i = 0u; i < BELOW; ++i) {
            if (!done && aheads[i].depth == depth) {
                done = true;
                // A curve may begin with a step, which the first node of all may too.
                if (nexts[i] == 0u && node_count > 0 && aheads[i].value != curve_unshadowed()) {
                    last = max(last, mean_optical_depth(depth));
                    curve_append(depth, last);
                }
                bool same = nexts[i] > 0u && aheads[i].depth == befores[i].depth && aheads[i].value == befores[i].value;
                befores[i] = aheads[i];
                ++nexts[i];
                aheads[i] = next_node(i);
                if (!same) {
                    last = max(last, mean_optical_depth(depth));
                    curve_append(depth, last);
                }
            }
        }
    }
    curve_reduce();
    Node curve[NODES];
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        curve[i] = curve_node(i);
    }
    store_curve(level_first(size, map_count, level) + (map * its.y + texel.y) * its.x + texel.x, curve);
}
