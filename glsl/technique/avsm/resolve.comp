#version 460
// Sorts each texel's list by entry depth and compresses it to NODES nodes. Source: Fife and Strugar 2013, Compression stage.
// Inputs: maps, heads, segments, counts. Outputs: nodes; the lists' links are rewritten by the sort.
// Invariant: a list of any length is inserted whole; ties go by exit and optical depth, so that the result depends
// neither on the order in which the fragments were captured nor on that of the casters.

// REFINE 1: with fit=refined, for which the whole curve, as long as it is, is kept at the ends of CELLS even cells.
// variants: REFINE 0 1
#include "technique/avsm/curve.glsl"
#include "technique/avsm/maps.glsl"
#include "technique/avsm/tiled.glsl"
#include "maps/list/segments.glsl"
#include "maps/rounds.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// True: by entry depth. False: as captured, which differs from run to run.
CONSTANT(bool, SORTED, true)

// set 1: list
layout(set = 1, binding = 0, r32ui) uniform uimage2D heads;
// Word by word: as one uvec4 each, NVIDIA 580.159 takes 1.1 times as long, of whole curves eight times.
layout(set = 1, binding = 1, scalar) buffer Segments { Segment segments[]; };
layout(set = 1, binding = 2, scalar) buffer Counters { uint counters[]; };
// set 2: avsm_curves
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };
layout(set = 2, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

#include "technique/avsm/store.glsl"

#if REFINE
const uint TEXELS = 64u;
const int CELLS = 64;
shared uint cells[CELLS * TEXELS];
shared vec4 fitted[NODES / 2 * TEXELS];
#define FITTED fitted
#include "technique/avsm/fit.glsl"

// Compresses the curve and moves the nodes that are left to where all of it wants them.
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

// Those that tie in all are the same.
bool before(Segment a, Segment b) {
    if (a.entry != b.entry) {
        return a.entry < b.entry;
    }
    return a.exit != b.exit ? a.exit < b.exit : a.optical_depth < b.optical_depth;
}

// Segments that are merged in a round, of which some drivers give few (maps/rounds.glsl).
const int MERGED_AT_ONCE = 16;

// Merges two sorted lists, neither empty, by rewriting their links. Each segment is read once.
uint merge(uint a, uint b) {
    Segment from_a = segments[a], from_b = segments[b];
    bool b_first = before(from_b, from_a);
    uint head = b_first ? b : a, tail = NO_SEGMENT, linked = NO_SEGMENT;
    [[dont_unroll]] while (true) {
        [[unroll]] for (int i = 0; i < MERGED_AT_ONCE; ++i) {
            b_first = before(from_b, from_a);
            uint least = b_first ? b : a;
            if (linked != least && tail != NO_SEGMENT) {
                segments[tail].next = least;
            }
            tail = least;
            linked = b_first ? from_b.next : from_a.next;
            if (linked == NO_SEGMENT) {
                segments[tail].next = b_first ? a : b;
                return head;
            }
            if (b_first) {
                b = linked;
                from_b = segments[b];
            } else {
                a = linked;
                from_a = segments[a];
            }
        }
    }
}

// Segments that are sorted in registers.
const int RUN = 16;

// Takes the first RUN segments off a list, or all, and sorts them: each goes to its place among those before it.
uint take_run(inout uint head) {
    Segment run[RUN];
    uint places[RUN];
    [[unroll]] for (int i = 0; i < RUN; ++i) {
        run[i] = Segment(FARTHEST, FARTHEST, FARTHEST, NO_SEGMENT);
        places[i] = NO_SEGMENT;
    }
    [[dont_unroll]] for (int n = 0; n < RUN && head != NO_SEGMENT; ++n) {
        Segment segment = segments[head];
        bool ahead = true;
        [[unroll]] for (int i = RUN - 1; i >= 0; --i) {
            // Those behind it move on by one; where the first that is not stands, the one behind that is free.
            bool moves = i > 0 && before(segment, run[max(i - 1, 0)]);
            if (moves) {
                run[i] = run[max(i - 1, 0)];
                places[i] = places[max(i - 1, 0)];
            } else if (ahead) {
                run[i] = segment;
                places[i] = head;
            }
            ahead = moves;
        }
        head = segment.next;
    }
    [[unroll]] for (int i = 0; i < RUN; ++i) {
        if (places[i] != NO_SEGMENT) {
            segments[places[i]].next = i + 1 < RUN ? places[min(i + 1, RUN - 1)] : NO_SEGMENT;
        }
    }
    return places[0];
}

// Bottom-up merge sort of a linked list: in place, no limit on its length. runs[i] is empty or holds RUN · 2^i segments.
uint sort(uint head) {
    uint runs[32];
    for (int i = 0; i < 32; ++i) {
        runs[i] = NO_SEGMENT;
    }
    int used = 0;
    while (head != NO_SEGMENT) {
        uint run = take_run(head);
        int i = 0;
        for (; i < 31 && runs[i] != NO_SEGMENT; ++i) {
            run = merge(runs[i], run);
            runs[i] = NO_SEGMENT;
        }
        runs[i] = run;
        used = max(used, i + 1);
    }
    uint sorted = NO_SEGMENT;
    for (int i = 0; i < used; ++i) {
        if (runs[i] != NO_SEGMENT) {
            sorted = sorted != NO_SEGMENT ? merge(runs[i], sorted) : runs[i];
        }
    }
    return sorted;
}

void main() {
    uvec2 size = map_size();
    if (tile_skipped(counts[group_tile()])) {
        return;
    }
    bool within = all(lessThan(gl_GlobalInvocationID.xy, size));
    uint index = NO_SEGMENT;
    if (within) {
        // The maps of the group stand one above the other.
        index = imageLoad(heads, ivec2(gl_GlobalInvocationID.xy + uvec2(0u, gl_WorkGroupID.z * size.y))).r;
    }
    if (SORTED) {
        index = sort(index);
    }
    curve_clear();
    while (index != NO_SEGMENT) {
        Segment segment = segments[index];
        if (SORTED && curve_dark(segment.entry)) {
            break;  // nor is there light for those behind it
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
