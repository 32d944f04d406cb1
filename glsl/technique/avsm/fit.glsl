// Moves the nodes of a compressed curve off the true curve, so that the lines between them better fit the true optical depths at the cells'
// ends. Two lines meet at a node, one from the previous node and one from the next. Each line is rotated about its far end until it best
// fits the cells' ends that it passes; the node moves to the intersection of the two rotated lines. This is a Gauss-Newton step of least
// squares in transmittance. Must be declared before inclusion: CELLS and TEXELS; cells[], which holds the optical depth up to each cell's
// end as float bits; FITTED, a shared vec4[NODES / 2 * TEXELS] or larger. All threads of a workgroup take part. Odd and even nodes take
// turns, since a node's new position depends only on its two neighbours.
// Invariants: depths and optical depths never decrease; the optical depth of the last node does not change; nodes from `dark_from` on do
// not move. Source: ours. Twin: reference::twin::avsm::fit.
#ifndef TECHNIQUE_AVSM_FIT_GLSL
#define TECHNIQUE_AVSM_FIT_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/curve/curve.glsl"

// Number of refinement passes, which move odd and even nodes alternately; 0: all nodes stay on the curve.
CONSTANT(int, TURNS, 0)

// Maximum distance that a node moves per pass, as a fraction of the distance to its neighbour.
const float REACH = 0.5;
// Minimum length assumed for a line, in cells: a step has length 0, so rounding error would decide where its ends move.
const float STEEP = 0.0625;
// Weights below this, which are squares of transmittance, are negligible.
const float DIM = 1e-7;
// Regularization added to the square of a node's change of slope, in optical depth per cell: a smaller change does not determine the node's
// depth.
const float STRAIGHT = 1e-10;

// Returns (depth, value) of node i of texel t; a vec4 holds two nodes.
vec2 fitted_at(uint i, uint t) {
    vec4 pair = FITTED[i / 2u * TEXELS + t];
    return i % 2u == 0u ? pair.xy : pair.zw;
}

// Writes half of a vec4: the other half belongs to a node that another thread may write at the same time.
void fit_node(uint i, uint t, vec2 node) {
    if (i % 2u == 0u) {
        FITTED[i / 2u * TEXELS + t].xy = node;
    } else {
        FITTED[i / 2u * TEXELS + t].zw = node;
    }
}

// Returns sums for the line between `neighbour` and `node`, each given as (position, value) and 1 / `per` apart, over the cells' ends
// between `from` and `to`. x: sum of weights. y: weighted sum of the optical depth at an end minus the line's value there. When `node`
// moves past an end, the end's weight passes from one of the node's two lines to the other: gradually, over half a cell on each side, so
// that the result is continuous.
vec2 line_sums(uint t, vec2 neighbour, vec2 node, float per, float from, float to) {
    uint first = uint(from), last = uint(to);
    vec2 sums = vec2(0.0);
    float rise = node.y - neighbour.y;
    // Four ends at a time, which are independent of each other.
    [[dont_unroll]] for (uint begin = first; begin < last; begin += 4u) {
        [[unroll]] for (uint i = 0u; i < 4u; ++i) {
            uint cell = min(begin + i, last - 1u);
            float end = float(cell + 1u);
            float share = (end - neighbour.x) * per;
            float belongs = begin + i < last ? clamp((node.x - end) * sign(per) + 0.5, 0.0, 1.0) : 0.0;
            float optical_depth = uintBitsToFloat(cells[cell * TEXELS + t]);
            float weight = exp(-2.0 * optical_depth) * share * belongs;
            sums += weight * vec2(share, optical_depth - (neighbour.y + rise * share));
        }
    }
    return sums;
}

// Returns the new depth and value of node i. Positions are in cells behind `low`.
vec2 fitted_node(uint t, uint i, float low, float per_cell, float dark_from) {
    vec2 node = fitted_at(i, t);
    bool is_first = i == 0u;
    bool is_last = i + 1u == NODES || fitted_at(i + 1u, t).x == EMPTY;
    if ((is_first && is_last) || node.x >= dark_from) {
        return node;
    }
    vec2 p = is_first ? node : fitted_at(i - 1u, t);
    vec2 q = is_last ? node : fitted_at(i + 1u, t);
    float at_p = (p.x - low) * per_cell, at = (node.x - low) * per_cell, at_q = (q.x - low) * per_cell;
    float per_p = 1.0 / max(at - at_p, STEEP), per_q = 1.0 / max(at_q - at, STEEP);
    float slope_p = (node.y - p.y) * per_p, slope_q = (q.y - node.y) * per_q;
    float dark = clamp((dark_from - low) * per_cell, 0.0, float(CELLS));
    vec2 placed = vec2(at, node.y);
    vec2 sums_p = line_sums(t, vec2(at_p, p.y), placed, per_p, at_p, min(at + 0.5, dark));
    vec2 sums_q = line_sums(t, vec2(at_q, q.y), placed, -per_q, max(at - 0.5, at_p), min(at_q, dark));
    // How far each line alone would raise the node.
    float wish_p = sums_p.y / (sums_p.x + DIM), wish_q = sums_q.y / (sums_q.x + DIM);
    float nearest = at - REACH * (at - at_p);
    float farthest = at + REACH * ((is_last ? float(CELLS) : at_q) - at);
    float moved, value;
    if (is_first) {
        // In front of the first node the transmittance is 1: its line ends in a step, or where its optical depth reaches 0.
        float wanted = node.y + wish_q;
        float slope = (q.y - wanted) * per_q;
        moved = wanted < 0.0 ? min(at - wanted / slope, farthest) : at;
        value = min(max(wanted, 0.0), q.y);
    } else if (is_last) {
        moved = min(max(at - wish_p * slope_p / (slope_p * slope_p + STRAIGHT), nearest), farthest);
        value = node.y;
    } else {
        float bend = slope_p - slope_q;
        moved = min(max(at + (wish_q - wish_p) * bend / (bend * bend + STRAIGHT), nearest), farthest);
        float by = moved - at;
        float both = sums_p.x * (wish_p + slope_p * by) + sums_q.x * (wish_q + slope_q * by);
        value = min(max(node.y + both / (sums_p.x + sums_q.x + DIM), p.y), q.y);
    }
    float end = is_last ? max(node.x, low + float(CELLS) / per_cell) : q.x;
    return vec2(min(max(low + moved / per_cell, p.x), end), value);
}

// Fits a texel's curve, with all `groups` threads of the texel. Before and after, the curve is in the arrays of maps/curve/curve.glsl of
// the thread whose `group` is 0.
void curve_fit(uint t, uint group, uint groups, float low, float per_cell, float dark_from) {
    if (group == 0u) {
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            fit_node(uint(i), t, vec2(node_depths[i], node_values[i]));
        }
    }
    barrier();
    [[dont_unroll]] for (int turn = 0; turn < TURNS; ++turn) {
        // Odd nodes first.
        uint parity = uint(turn + 1) % 2u;
        [[dont_unroll]] for (uint i = parity + 2u * group; i < NODES; i += 2u * groups) {
            if (fitted_at(i, t).x < EMPTY) {
                fit_node(i, t, fitted_node(t, i, low, per_cell, dark_from));
            }
        }
        barrier();
    }
    if (group == 0u) {
        [[unroll]] for (int i = 0; i < NODES; ++i) {
            vec2 node = fitted_at(uint(i), t);
            node_depths[i] = node.x;
            node_values[i] = node.y;
        }
    }
}
#endif
