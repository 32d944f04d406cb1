// Removes nodes whose removal hardly changes the area under the transmittance, and moves their neighbours to preserve the area, as in the
// curves of Salvi et al. 2010, but without a fixed number of nodes. A window slides along the curve: if none of its nodes can be removed
// within the limit, its first node becomes final. Must be declared before inclusion: keep_node(Node), which is called for each final node,
// and `kept`, the number of final nodes. Source: ours, except for the removal. Twin: reference::twin::deep_shadow_map::area. Invariants:
// depths and optical depths never decrease; the first node and the last do not change.
//
// The arrays are meant to stay in registers: loops are unrolled, every index is a constant, and a node chosen at run time is selected by
// comparison. This also helps drivers that allow an invocation only a limited number of loop iterations (maps/rounds.glsl).
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_AREA_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_AREA_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "technique/deep_shadow_map/node.glsl"

// Number of nodes that may still be removed.
const int WINDOW = 16;

// The window: first the last node that was kept, if any, then the nodes that may still be removed. Two more arrays hold each node's
// transmittance, and the area under the curve from the node to the next.
Node window_nodes[WINDOW + 1];
float window_through[WINDOW + 1];
float window_areas[WINDOW + 1];
int window_count;
// Largest change of the area that the removal of a node may cause.
float most_change;

void window_begin(float most) {
    most_change = most;
    window_count = 0;
    [[unroll]] for (int i = 0; i < WINDOW + 1; ++i) {
        window_nodes[i] = Node(0.0, 0.0);
        window_through[i] = 1.0;
        window_areas[i] = 0.0;
    }
}

// Returns the area under the transmittance between two nodes. `start`, `end`: the transmittance at each.
float span_area(Node from, float start, Node to, float end) {
    float rise = to.value - from.value, square = rise * rise;
    float mean = rise < 0.25 ? 0.5 * (start + end) * (1.0 - square * (1.0 / 12.0 - square / 120.0)) : (start - end) / rise;
    return mean * (to.depth - from.depth);
}

float window_area(int from, int to) {
    return span_area(window_nodes[from], window_through[from], window_nodes[to], window_through[to]);
}

void remove_at(int gone) {
    --window_count;
    [[unroll]] for (int i = 0; i < WINDOW; ++i) {
        if (i >= gone) {
            window_nodes[i] = window_nodes[i + 1];
            window_through[i] = window_through[i + 1];
            window_areas[i] = window_areas[i + 1];
        }
    }
}

// Keeps the first node that may still be removed.
void keep_first() {
    if (kept == 0u) {
        keep_node(window_nodes[0]);
    }
    remove_at(0);
    keep_node(window_nodes[0]);
}

// Removes the node whose removal changes the area least, if the change is within the limit.
bool remove_least() {
    int gone = 0;
    float least = 3e38, change = 0.0, weight = 0.0, low = 0.0, high = 0.0;
    [[unroll]] for (int i = 1; i < WINDOW; ++i) {
        float its = window_area(i - 1, i + 1) - (window_areas[i - 1] + window_areas[i]);
        if (i + 1 < window_count && abs(its) < least) {
            bool is_second = i == 1, is_last_but_one = i + 2 >= window_count;
            float both = window_nodes[i + 1].value - window_nodes[i - 1].value;
            gone = i;
            least = abs(its);
            change = its;
            weight = (is_second ? 0.0 : 0.5 * window_areas[max(i, 2) - 2]) + window_areas[i - 1] + window_areas[i] +
                     (is_last_but_one ? 0.0 : 0.5 * window_areas[i + 1]);
            low = is_second ? -both : window_nodes[max(i, 2) - 2].value - window_nodes[i - 1].value;
            high = is_last_but_one ? both : window_nodes[min(i + 2, WINDOW)].value - window_nodes[i + 1].value;
        }
    }
    if (least > most_change) {
        return false;
    }
    float shift = weight > 1e-12 ? min(max(change / weight, low), high) : 0.0;
    bool has_before = gone >= 2, has_behind = gone + 2 < window_count;
    [[unroll]] for (int i = 0; i < WINDOW + 1; ++i) {
        if ((i == gone - 1 && has_before) || (i == gone + 1 && has_behind)) {
            window_nodes[i].value += shift;
            window_through[i] = exp(-window_nodes[i].value);
        }
    }
    remove_at(gone);
    [[unroll]] for (int i = 0; i < WINDOW; ++i) {
        if (i >= gone - 2 && i <= gone) {
            window_areas[i] = window_area(i, i + 1);
        }
    }
    return true;
}

void window_point(Node point) {
    Node first = window_nodes[0];
    // If the curve begins with a step, the step's second node replaces its first.
    window_count = kept == 0u && window_count == 1 && first.depth == point.depth ? 0 : window_count;
    float through = exp(-point.value);
    bool is_new = true;
    [[unroll]] for (int i = 0; i < WINDOW + 1; ++i) {
        is_new = is_new && !(i + 1 == window_count && window_nodes[i] == point);
        if (is_new && i == window_count) {
            window_nodes[i] = point;
            window_through[i] = through;
            window_areas[max(i, 1) - 1] = window_area(max(i, 1) - 1, i);
        }
    }
    window_count += int(is_new);
    if (window_count > WINDOW && !remove_least()) {
        keep_first();
    }
}

void window_finish() {
    [[dont_unroll]] while (remove_least()) {
    }
    bool has_kept = kept > 0u;
    [[unroll]] for (int i = 0; i < WINDOW + 1; ++i) {
        if (i < window_count && !(i == 0 && has_kept)) {
            keep_node(window_nodes[i]);
        }
    }
}
#endif
