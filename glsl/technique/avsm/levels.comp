#version 460
// Builds levels of detail of all maps: a texel's curve is the mean transmittance of the four below it, at nodes between the first of
// theirs and the last. These stand where depth and the loss of light, half and half, have gone on evenly: a thread a node, none of which
// waits for another. What is past the map's edge, or has no casters, lets all light through. Source: ours.
// Inputs: maps, nodes of the level below, counts. Output: nodes of the levels. Twin: reference::twin::avsm::levels.
// Invariant: at its nodes and behind them it is the mean of what the four have there, to what storing rounds.
#include "maps/level_tile.glsl"
#include "technique/avsm/tiled.glsl"

// set 1: avsm_levels
layout(set = 1, binding = 0, scalar) coherent buffer Nodes { uvec2 nodes[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

uvec2 curve_pair(uint i) { return nodes[i]; }

#include "technique/avsm/store.glsl"
#include "technique/avsm/read.glsl"

// Where the loss of light is looked at before nodes are placed: as many even steps of depth.
const uint STEPS = NODES < 8 ? 16u : 2u * uint(NODES);

// Curves of the texels below, rows of the tile; of those that are made ranges, means at the ends of steps, and nodes.
shared Node below_nodes[BELOW * MADE * NODES];
shared vec2 ranges[MADE];
shared float means[MADE * (STEPS + 1u)];
shared Node made_nodes[MADE * NODES];

// Where the curve of texel i of the four below texel t begins.
uint below_curve(LevelTile tile, uint t, uint i) {
    uvec2 at = below_texel(tile, t, i);
    return (at.y * 2u * tile.side + at.x) * uint(NODES);
}

// All of the level below, decoded; a thread a node.
void read_below(LevelTile tile) {
    uint side = 2u * tile.side;
    [[dont_unroll]] for (uint i = gl_LocalInvocationIndex; i < side * side * uint(NODES); i += LEVEL_THREADS) {
        uint texel = i / uint(NODES);
        uint place = below_place(tile, uvec2(texel % side, texel / side));
        if (place != NONE && tile.level == 1u) {
            uvec2 tiles = gl_NumWorkGroups.xy;
            uint count = counts[(gl_WorkGroupID.z * tiles.y + gl_WorkGroupID.y) * tiles.x + gl_WorkGroupID.x];
            place = tile_skipped(count) ? NONE : place;
        }
        uint at = place * curve_pairs();
        Node node = Node(EMPTY, curve_unshadowed());
        if (place != NONE) {
            node = texel_node(at, i % uint(NODES), curve_range(at));
        }
        below_nodes[i] = node;
    }
}

float curve_at(uint curve, float depth) {
    uint before = 0u;
    for (uint i = 0u; i < uint(NODES); ++i) {
        before += uint(below_nodes[curve + i].depth <= depth);
    }
    if (before == 0u) {
        return 1.0;
    }
    Node near = below_nodes[curve + before - 1u], far = below_nodes[curve + min(before, uint(NODES) - 1u)];
    float extent = far.depth - near.depth;
    float along = far.depth < EMPTY && extent > 0.0 ? clamp((depth - near.depth) / extent, 0.0, 1.0) : 0.0;
    return curve_transmittance(mix(near.value, far.value, along));
}

float mean_at(LevelTile tile, uint t, float depth) {
    float mean = 0.0;
    for (uint i = 0u; i < BELOW; ++i) {
        mean += 0.25 * curve_at(below_curve(tile, t, i), depth);
    }
    return min(mean, 1.0);
}

// From the first node of the four to the last.
vec2 merged_range(LevelTile tile, uint t) {
    vec2 range = vec2(EMPTY, -EMPTY);
    for (uint i = 0u; i < BELOW; ++i) {
        uint curve = below_curve(tile, t, i);
        bool casts = below_nodes[curve + uint(NODES) - 1u].value != curve_unshadowed();
        for (uint k = 0u; casts && k < uint(NODES); ++k) {
            float depth = below_nodes[curve + k].depth;
            range = depth < EMPTY ? vec2(min(range.x, depth), max(range.y, depth)) : range;
        }
    }
    return range;
}

// The place of node i in the range, 0 to 1: where so many of the nodes' parts of the way have been gone.
float node_place(uint t, uint i) {
    if (i == 0u || i == uint(NODES) - 1u) {
        return i == 0u ? 0.0 : 1.0;
    }
    uint first = t * (STEPS + 1u);
    float begin = means[first], loss = begin - means[first + STEPS];
    float wanted = float(i) / float(NODES - 1), before = 0.0;
    for (uint k = 1u; k <= STEPS; ++k) {
        float depth = float(k) / float(STEPS);
        float way = loss > 0.0 ? 0.5 * (depth + (begin - means[first + k]) / loss) : depth;
        if (way >= wanted) {
            return (float(k - 1u) + clamp((wanted - before) / (way - before), 0.0, 1.0)) / float(STEPS);
        }
        before = way;
    }
    return 1.0;
}

void make_level(LevelTile tile) {
    uint thread = gl_LocalInvocationIndex, count = tile_texels(tile);
    read_below(tile);
    barrier();
    if (thread < count) {
        ranges[thread] = merged_range(tile, thread);
    }
    barrier();
    for (uint i = thread; i < count * (STEPS + 1u); i += LEVEL_THREADS) {
        uint t = i / (STEPS + 1u);
        means[i] = mean_at(tile, t, mix(ranges[t].x, ranges[t].y, float(i % (STEPS + 1u)) / float(STEPS)));
    }
    barrier();
    for (uint i = thread; i < count * uint(NODES); i += LEVEL_THREADS) {
        uint t = i / uint(NODES), k = i % uint(NODES);
        vec2 range = ranges[t];
        Node node = Node(EMPTY, curve_unshadowed());
        if (range.x <= range.y) {
            float depth = k + 1u == uint(NODES) ? range.y : mix(range.x, range.y, node_place(t, k));
            float mean = mean_at(tile, t, depth);
            node = Node(depth, !EXPONENTIAL ? mean : mean < 1.0 ? min(-log(max(mean, 1e-35)), MAX_OPTICAL_DEPTH) : 0.0);
        }
        made_nodes[i] = node;
    }
    barrier();
    uint place = thread < count ? made_place(tile, thread) : NONE;
    if (place == NONE) {
        return;
    }
    Node curve[NODES];
    [[unroll]] for (int i = 0; i < NODES; ++i) {
        curve[i] = made_nodes[thread * uint(NODES) + uint(i)];
        // Means round.
        if (i > 0) {
            curve[i].value = EXPONENTIAL ? max(curve[i].value, curve[i - 1].value) : min(curve[i].value, curve[i - 1].value);
        }
    }
    store_curve(place, curve);
}
