#version 460
// Sorts each texel's list by entry depth and compresses it to NODES nodes. Source: Fife and Strugar 2013, Compression stage. Inputs: maps,
// heads, segments, counts. Outputs: nodes; the sort rewrites the lists' links. Invariant: lists of any length are inserted completely; ties
// are broken by exit and optical depth, so that the result depends neither on the order in which the fragments were captured nor on the
// order of the casters.

// REFINE 1: for fit=refined, which samples the uncompressed curve at the ends of CELLS equal cells and fits the nodes to it.
// variants: REFINE 0 1
#include "maps/curve/curve.glsl"
#include "technique/avsm/maps.glsl"
#include "maps/curve/tiled.glsl"
#include "maps/list/segments.glsl"
#include "maps/rounds.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// True: sorted by entry depth. False: in capture order, which differs from run to run.
CONSTANT(bool, SORTED, true)

// set 1: list
layout(set = 1, binding = 0, r32ui) uniform uimage2D heads;
// Read word by word: with one uvec4 per segment, NVIDIA 580.159 takes 1.1 times as long (eight times if whole curves are read that way).
layout(set = 1, binding = 1, scalar) buffer Segments { Segment segments[]; };
layout(set = 1, binding = 2, scalar) buffer Counters { uint counters[]; };
// set 2: curves
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };
layout(set = 2, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

#include "maps/curve/store.glsl"

#if REFINE
const uint TEXELS = 64u;
const int CELLS = 64;
shared uint cells[CELLS * TEXELS];
shared vec4 fitted[NODES / 2 * TEXELS];
#define FITTED fitted
#include "technique/avsm/fit.glsl"

// Compresses the curve and fits the remaining nodes to the uncompressed curve.
void curve_reduce_refined() {
    uint t = gl_LocalInvocationIndex;
    float low = node_depths[0], high = low, dark_from = EMPTY;
    [[unroll]] for (int i = WORK - 1; i > 0; --i) {
        bool dark = node_depths[i] < EMPTY && node_values[i] - node_values[i - 1] >= DARK;
        dark_from = dark ? node_depths[i - 1] : dark_from;
        high = dark ? node_depths[i] : max(high, node_depths[i] < EMPTY ? node_depths[i] : low);
    }
    float per_cell = float(CELLS) / max(high - low, 1e-6);
    [[dont_unroll]] for (int i = 0; i < CELLS; ++i) {
        cells[uint(i) * TEXELS + t] = floatBitsToUint(node_count > 0 ? curve_value(low + float(i + 1) / per_cell) : 0.0);
    }
    curve_reduce();
    curve_fit(t, 0u, 1u, low, per_cell, dark_from);
}
#endif

#define SORTED_LIST segments
#include "maps/list/sort.glsl"

void main() {
    uvec2 size = map_size();
    if (tile_skipped(counts[group_tile()])) {
        return;
    }
    bool within = all(lessThan(gl_GlobalInvocationID.xy, size));
    uint index = NO_SEGMENT;
    if (within) {
        // The maps of the group are stacked vertically.
        index = imageLoad(heads, ivec2(gl_GlobalInvocationID.xy + uvec2(0u, gl_WorkGroupID.z * size.y))).r;
    }
    if (SORTED) {
        index = sort(index);
    }
    curve_clear();
    while (index != NO_SEGMENT) {
        Segment segment = segments[index];
        if (SORTED && curve_dark(segment.entry)) {
            break;  // no light is left for segments behind it
        }
        curve_insert(segment.entry, segment.exit, segment.optical_depth);
        index = segment.next;
    }
    if (rounds_ran_out(uint(node_count))) {
        counters[CUT_SHORT] = 1u;
    }
#if REFINE
    curve_reduce_refined();
#else
    curve_reduce();
#endif
    if (within) {
        store_curve(group_texel(group_map()));
    }
}
