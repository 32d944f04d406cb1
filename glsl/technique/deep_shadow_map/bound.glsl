// Finds the fewest nodes whose lines stay within an error of a texel's curve, greedily. A line that begins at a node is prolonged as long
// as there is a slope with which it passes through the windows of all points on the way. A point's window is a range of optical depths:
// those whose transmittance differs from the curve's transmittance at the point by at most the error. Source: Lokovic and Veach 2000;
// windows in optical depth, and those between the ends of long rises, are ours. Needs, declared before: keep_node(Node), which is called
// for each final node, and last_kept. Twin: reference::twin::deep_shadow_map::bound. Invariants: at every depth, at points and between
// them, the lines' transmittance is within the error of the curve's; depths never fall, nor do optical depths; behind the last node the
// transmittance is within TAIL of the product of all segments' transmittances.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_BOUND_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_BOUND_GLSL
#include "technique/deep_shadow_map/node.glsl"

// Along a straight rise of optical depth the bounds of the windows are curved. A line that is within the windows at both ends of the rise
// may therefore leave them in between. So a rise of more than RISE has more windows on its way. Between two of these windows the error of a
// line may be greater by a share of BETWEEN, which is RISE² / 4.
const float RISE = 0.25;
const float BETWEEN = 1.0 / 64.0;
// The error of the transmittance at the last node.
const float TAIL = 1e-4;
const float ANY_SLOPE = 3e38;

// The present line: the node that it begins at, which does not exist before the first point; its possible slopes; and
// its last point.
bool has_start;
Node line_start;
vec2 line_slopes;
Node line_end;
float curve_error;
// Optical depth of the whole curve. No line rises above it, so that none has to fall to the last node.
float curve_total;

// The optical depth from which on it is so dark that errors of lines do not matter.
float dark_from(float error) { return 5.0 - log(2.0 * error); }

// Begins a curve with the optical depth `total` in all.
void line_begin(float error, float total) {
    curve_error = error * (1.0 - BETWEEN);
    curve_total = total;
    has_start = false;
}

// The optical depths whose transmittance is within `error` of that of `value`.
vec2 window(float value, float error) {
    float through = exp(-value);
    float low = -log(min(through + error, 1.0));
    // The upper bound is a curve over the optical depth. A line that is below the bound at two points must also be below it between them.
    // So where the error is more than half of the light that is left, the bound is replaced by its tangent at the place where the error is
    // exactly half.
    float high = through >= 2.0 * error ? -log(through - error) : 2.0 * value + log(2.0 * error) * 2.0 - log(error);
    return vec2(max(low, 0.0), high);
}

void start_line(Node node) {
    line_start = line_end = node;
    line_slopes = vec2(0.0, ANY_SLOPE);
}

// Ends the line at the depth of its last point, as near to the point as the slopes allow.
void end_line() {
    float along = line_end.depth - line_start.depth;
    if (along > 0.0) {
        vec2 reach = line_start.value + line_slopes * along;
        Node node = Node(line_end.depth, clamp(line_end.value, reach.x, reach.y));
        keep_node(line_start);
        start_line(node);
    }
}

// Adds a step of the curve at the depth of the last node. The first step has no node in front of it. If several steps are at one depth, the
// last step counts.
void add_step(Node point) {
    if (kept > 0u && last_kept.depth < point.depth) {
        keep_node(line_start);
    }
    start_line(Node(point.depth, max(point.value, last_kept.value)));
}

// The curve's next point; two at one depth are a step.
void line_point(Node point, bool is_last) {
    vec2 its = window(point.value, is_last ? min(curve_error, TAIL) : curve_error);
    its.y = min(its.y, max(curve_total, point.value));
    if (!has_start) {
        has_start = true;
        start_line(point);
        return;
    }
    float along = point.depth - line_start.depth;
    if (along > 0.0) {
        vec2 slopes = (its - line_start.value) / along;
        slopes = vec2(max(line_slopes.x, slopes.x), min(line_slopes.y, slopes.y));
        if (slopes.x > slopes.y) {
            end_line();
            along = point.depth - line_start.depth;
            // From the new node, some slope passes the point's window.
            slopes = along > 0.0 ? (its - line_start.value) / along : slopes;
            slopes.x = max(slopes.x, 0.0);
        }
        if (along > 0.0) {
            line_slopes = slopes;
            line_end = point;
            if (is_last) {
                end_line();
            }
            return;
        }
    }
    if (line_start.value < its.x || line_start.value > its.y) {
        add_step(point);
    }
}

void line_finish() {
    if (has_start) {
        keep_node(line_start);
    }
}
#endif
