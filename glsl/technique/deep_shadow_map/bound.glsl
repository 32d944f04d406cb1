// Greedily finds the fewest nodes whose lines stay within an error bound of a texel's curve. A line from a node is extended as long as some
// slope takes it through the windows of all points along it. A point's window is the range of optical depths whose transmittance differs
// from the curve's transmittance at the point by at most the error bound. Source: Lokovic and Veach 2000; windows in optical depth, and
// those between the ends of long rises, are ours. Must be declared before inclusion: keep_node(Node), which is called for each final node,
// kept and last_kept. Twin: reference::twin::deep_shadow_map::bound. Invariants: at every depth, at points and between them, the lines'
// transmittance is within the error bound of the curve's transmittance; depths and optical depths never decrease; behind the last node the
// transmittance is within TAIL of the product of all segments' transmittances.
#ifndef TECHNIQUE_DEEP_SHADOW_MAP_BOUND_GLSL
#define TECHNIQUE_DEEP_SHADOW_MAP_BOUND_GLSL
#include "technique/deep_shadow_map/node.glsl"

// Along a linear rise of optical depth the bounds of the windows are curved, so a line that is within the windows at both ends of the rise
// may leave them in between. A rise of more than RISE therefore gets additional windows. Between two of these windows, a line may exceed
// the error bound by the fraction BETWEEN of it, which is RISE² / 4.
const float RISE = 0.25;
const float BETWEEN = 1.0 / 64.0;
// Error bound of the transmittance at the last node.
const float TAIL = 1e-4;
const float ANY_SLOPE = 3e38;

// The current line: its start node, which does not exist before the first point; its possible slopes; and its last point.
bool has_start;
Node line_start;
vec2 line_slopes;
Node line_end;
float curve_error;
// Optical depth of the whole curve. No line rises above it, so that none has to descend to the last node.
float curve_total;

// Returns the optical depth beyond which it is so dark that the lines' errors do not matter.
float dark_from(float error) { return 5.0 - log(2.0 * error); }

// Begins a curve with a total optical depth of `total`.
void line_begin(float error, float total) {
    curve_error = error * (1.0 - BETWEEN);
    curve_total = total;
    has_start = false;
}

// Returns the range of optical depths whose transmittance is within `error` of the transmittance of `value`.
vec2 window(float value, float error) {
    float through = exp(-value);
    float low = -log(min(through + error, 1.0));
    // The upper bound is curved over the optical depth. A line that is below the bound at two points must also stay below it between them.
    // So where the error is more than half of the remaining light, the bound is replaced by its tangent at the point where the error is
    // exactly half.
    float high = through >= 2.0 * error ? -log(through - error) : 2.0 * value + log(2.0 * error) * 2.0 - log(error);
    return vec2(max(low, 0.0), high);
}

void start_line(Node node) {
    line_start = line_end = node;
    line_slopes = vec2(0.0, ANY_SLOPE);
}

// Ends the line at the depth of its last point, as close to the point as the slopes allow.
void end_line() {
    float along = line_end.depth - line_start.depth;
    if (along > 0.0) {
        vec2 reach = line_start.value + line_slopes * along;
        Node node = Node(line_end.depth, clamp(line_end.value, reach.x, reach.y));
        keep_node(line_start);
        start_line(node);
    }
}

// Adds a step of the curve at the depth of the last node. The first step has no node in front of it. If several steps have the same depth,
// the last one counts.
void add_step(Node point) {
    if (kept > 0u && last_kept.depth < point.depth) {
        keep_node(line_start);
    }
    start_line(Node(point.depth, max(point.value, last_kept.value)));
}

// Adds the curve's next point; two points at the same depth form a step.
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
            // From the new node, some slope passes through the point's window.
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
