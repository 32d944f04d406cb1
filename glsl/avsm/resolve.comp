#version 460
// Sorts each texel's list by entry depth and compresses it to NODES nodes. Source: Fife and Strugar 2013, Compression stage.
// Inputs: maps, heads, segments, counts. Outputs: nodes; the lists' links are rewritten by the sort.
// Invariant: a list of any length is inserted whole; ties go by exit, optical depth and caster index, so that the result depends
// neither on the order in which the fragments were captured nor on that of the casters.
#include "avsm/curve.glsl"
#include "avsm/maps.glsl"
#include "avsm/tiled.glsl"
#include "list/segments.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// True: by entry depth. False: as captured, which differs from run to run.
CONSTANT(bool, SORTED, true)

layout(set = 1, binding = 0, r32ui) uniform uimage2D heads;
layout(set = 1, binding = 1, scalar) buffer Segments { Segment segments[]; };
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };
layout(set = 2, binding = 1, scalar) readonly buffer Counts { uint counts[]; };

#include "avsm/store.glsl"

bool before(uint a, uint b) {
    vec2 depth_a = vec2(segments[a].entry, segments[a].exit), depth_b = vec2(segments[b].entry, segments[b].exit);
    float optical_depth_a = segments[a].optical_depth, optical_depth_b = segments[b].optical_depth;
    if (depth_a.x != depth_b.x) {
        return depth_a.x < depth_b.x;
    }
    if (depth_a.y != depth_b.y) {
        return depth_a.y < depth_b.y;
    }
    return optical_depth_a < optical_depth_b
        || (optical_depth_a == optical_depth_b && segments[a].caster < segments[b].caster);
}

// Merges two sorted lists by rewriting their links.
uint merge(uint a, uint b) {
    uint head = NO_SEGMENT, tail = NO_SEGMENT;
    while (a != NO_SEGMENT && b != NO_SEGMENT) {
        uint least;
        if (before(b, a)) {
            least = b;
            b = segments[b].next;
        } else {
            least = a;
            a = segments[a].next;
        }
        if (tail == NO_SEGMENT) {
            head = least;
        } else {
            segments[tail].next = least;
        }
        tail = least;
    }
    uint rest = a != NO_SEGMENT ? a : b;
    if (tail == NO_SEGMENT) {
        return rest;
    }
    segments[tail].next = rest;
    return head;
}

// Bottom-up merge sort of a linked list: in place, no limit on its length. runs[i] is empty or holds 2^i segments.
uint sort(uint head) {
    uint runs[32];
    for (int i = 0; i < 32; ++i) {
        runs[i] = NO_SEGMENT;
    }
    int used = 0;
    while (head != NO_SEGMENT) {
        uint run = head;
        head = segments[head].next;
        segments[run].next = NO_SEGMENT;
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
        sorted = merge(runs[i], sorted);
    }
    return sorted;
}

void main() {
    uvec2 size = map_size();
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, size)) || tile_skipped(counts[group_tile()])) {
        return;
    }
    // The maps of the group stand one above the other.
    uint index = imageLoad(heads, ivec2(gl_GlobalInvocationID.xy + uvec2(0u, gl_WorkGroupID.z * size.y))).r;
    if (SORTED) {
        index = sort(index);
    }
    curve_clear();
    while (index != NO_SEGMENT) {
        Segment segment = segments[index];
        curve_insert(segment.entry, segment.exit, segment.optical_depth);
        index = segment.next;
    }
    curve_reduce();
    store_curve(group_texel(group_map()));
}
