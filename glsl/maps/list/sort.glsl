// Sorts a texel's list by entry depth, ties by exit and optical depth, by rewriting its links. SORTED_LIST, defined before inclusion, is
// the buffer of segments.
#ifndef MAPS_LIST_SORT_GLSL
#define MAPS_LIST_SORT_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/list/segments.glsl"

// Segments that tie in all three are equal.
bool before(Segment a, Segment b) {
    if (a.entry != b.entry) {
        return a.entry < b.entry;
    }
    return a.exit != b.exit ? a.exit < b.exit : a.optical_depth < b.optical_depth;
}

// Number of segments merged per loop iteration: some drivers limit the number of iterations (maps/rounds.glsl).
const int MERGED_AT_ONCE = 16;

// Merges two sorted lists, neither empty, by rewriting their links. Each segment is read once.
uint merge(uint a, uint b) {
    Segment from_a = SORTED_LIST[a], from_b = SORTED_LIST[b];
    bool b_first = before(from_b, from_a);
    uint head = b_first ? b : a, tail = NO_SEGMENT, linked = NO_SEGMENT;
    [[dont_unroll]] while (true) {
        [[unroll]] for (int i = 0; i < MERGED_AT_ONCE; ++i) {
            b_first = before(from_b, from_a);
            uint least = b_first ? b : a;
            if (linked != least && tail != NO_SEGMENT) {
                SORTED_LIST[tail].next = least;
            }
            tail = least;
            linked = b_first ? from_b.next : from_a.next;
            if (linked == NO_SEGMENT) {
                SORTED_LIST[tail].next = b_first ? a : b;
                return head;
            }
            if (b_first) {
                b = linked;
                from_b = SORTED_LIST[b];
            } else {
                a = linked;
                from_a = SORTED_LIST[a];
            }
        }
    }
}

// Number of segments sorted in registers.
const int RUN = 16;

// Takes the first RUN segments off a list, or all of them, and sorts them by insertion.
uint take_run(inout uint head) {
    Segment run[RUN];
    uint places[RUN];
    [[unroll]] for (int i = 0; i < RUN; ++i) {
        run[i] = Segment(FARTHEST, FARTHEST, FARTHEST, NO_SEGMENT);
        places[i] = NO_SEGMENT;
    }
    [[dont_unroll]] for (int n = 0; n < RUN && head != NO_SEGMENT; ++n) {
        Segment segment = SORTED_LIST[head];
        bool ahead = true;
        [[unroll]] for (int i = RUN - 1; i >= 0; --i) {
            // Segments that sort behind the new one shift by one place. That frees the place behind the last segment that stays.
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
            SORTED_LIST[places[i]].next = i + 1 < RUN ? places[min(i + 1, RUN - 1)] : NO_SEGMENT;
        }
    }
    return places[0];
}

// Bottom-up merge sort of a linked list: in place, for lists of any length. runs[i] is empty or holds RUN · 2^i segments.
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
#endif
