// Nodes go whose going changes the area under the transmittance by little, and their neighbours move so that it stays, as AVSM's do; but
// there is no number of nodes. A window goes along the curve: where the least change is too much, its first node stays.
// Needs, declared before: keep_node(Node), of a node that is final, and `kept`, their number. Source: Salvi et al. 2010, the removal; the
// rest is ours. Twin: reference::twin::deep_shadow_map::area.
// Invariants: depths never fall, nor do optical depths; the first node and the last stay as they are.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_AREA_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_AREA_GLSL
#include "technique/deep_shadow_map/node.glsl"

// Nodes that may still go.
const int WINDOW = 16;

// The first is the last of those that are kept, where there are any.
Node window_nodes[WINDOW + 1];
// Under the curve between a node and the next.
float window_areas[WINDOW + 1];
int window_count;
// Removals that change the area by more are none.
float most_change;

void window_begin(float most) {
    most_change = most;
    window_count = 0;
}

// Under the transmittance between two nodes.
float span_area(Node from, Node to) {
    float start = exp(-from.value), end = exp(-to.value), rise = to.value - from.value, square = rise * rise;
    float mean = rise < 0.25 ? 0.5 * (start + end) * (1.0 - square * (1.0 / 12.0 - square / 120.0)) : (start - end) / rise;
    return mean * (to.depth - from.depth);
}

void remove_at(int gone) {
    --window_count;
    for (int i = gone; i < window_count; ++i) {
        window_nodes[i] = window_nodes[i + 1];
        window_areas[i] = window_areas[i + 1];
    }
}

// The first that may go stays.
void keep_first() {
    if (kept == 0u) {
        keep_node(window_nodes[0]);
    }
    remove_at(0);
    keep_node(window_nodes[0]);
}

// Removes the node whose going changes the area least, if that is little enough.
bool remove_least() {
    int gone = 0;
    float least = 3e38, change = 0.0;
    for (int i = 1; i + 1 < window_count; ++i) {
        float its = span_area(window_nodes[i - 1], window_nodes[i + 1]) - (window_areas[i - 1] + window_areas[i]);
        if (abs(its) < least) {
            gone = i;
            least = abs(its);
            change = its;
        }
    }
    if (least > most_change) {
        return false;
    }
    bool has_before = gone >= 2, has_behind = gone + 2 < window_count;
    float before = window_nodes[gone - 1].value, behind = window_nodes[gone + 1].value, both = behind - before;
    float weight = window_areas[gone - 1] + window_areas[gone] + (has_before ? 0.5 * window_areas[max(gone, 2) - 2] : 0.0) +
                   (has_behind ? 0.5 * window_areas[gone + 1] : 0.0);
    float low = has_before ? window_nodes[max(gone, 2) - 2].value - before : -both;
    float high = has_behind ? window_nodes[min(gone + 2, WINDOW)].value - behind : both;
    float shift = weight > 1e-12 ? min(max(change / weight, low), high) : 0.0;
    window_nodes[gone - 1].value += has_before ? shift : 0.0;
    window_nodes[gone + 1].value += has_behind ? shift : 0.0;
    remove_at(gone);
    for (int i = max(gone - 2, 0); i <= gone && i + 1 < window_count; ++i) {
        window_areas[i] = span_area(window_nodes[i], window_nodes[i + 1]);
    }
    return true;
}

void window_point(Node point) {
    if (window_count > 0) {
        Node last = window_nodes[window_count - 1];
        if (last == point) {
            return;
        }
        // A step in front of which there is nothing.
        window_count = kept == 0u && window_count == 1 && last.depth == point.depth ? 0 : window_count;
    }
    window_nodes[window_count] = point;
    if (window_count > 0) {
        window_areas[window_count - 1] = span_area(window_nodes[window_count - 1], point);
    }
    ++window_count;
    if (window_count > WINDOW && !remove_least()) {
        keep_first();
    }
}

void window_finish() {
    while (remove_least()) {
    }
    for (int i = kept > 0u ? 1 : 0; i < window_count; ++i) {
        keep_node(window_nodes[i]);
    }
}
#endif
