#version 460
// Fits the views of all maps to their casters and meshes. Twin: reference::twin::fit; its truth is scene::View, in f64. One thread per map.
// Inputs: extents; maps, whose `near` is the smallest allowed near distance of a perspective view, as a fraction of the range, and whose
// `far` is the view's range, as a multiple of the casters' range. Output: maps. Invariant: a view contains all casters that it was fitted
// to; its margin exceeds the rounding error of the extents.
#include "maps/extents.glsl"
#include "world/light.glsl"

layout(local_size_x = 64) in;

// set 0: maps_fit
layout(set = 0, binding = 0, scalar) buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer AllExtents { Extents extents[]; };

layout(push_constant, scalar) uniform FitPush {
    uint map_count;
    uint only_meshes;  // 1: no translucent casters, so the volume is fitted to the meshes
    uint cascade_maps; // number of maps of all lights in one cascade; the cascades are stored back to back
    vec3 eye;
    vec3 ahead;        // the camera's forward direction, unit length
};

// Factor that widens a range by a hundredth of a texel of the largest map.
const float MARGIN = 1.00001;
// Rounding error bound, as a fraction of the distance from the origin.
const float ROUNDING = 5e-7;
// Smallest depth range of a parallel view, as a fraction of its width. Level ground straight under the light has almost no depth range, too
// little for floats to resolve.
const float THINNEST = 1e-3;

struct Range {
    vec3 low;
    vec3 high;
};

Range range_of(uint map, uint first) {
    Range range;
    for (uint axis = 0u; axis < 3u; ++axis) {
        range.low[axis] = float_of_order(extents[map].low[first + axis]);
        range.high[axis] = float_of_order(extents[map].high[first + axis]);
    }
    // No caster or mesh: an empty range.
    if (extents[map].high[first] == 0u) {
        range.low = vec3(FARTHEST);
        range.high = vec3(-FARTHEST);
    }
    return range;
}

// Fits a parallel view around the whole range; the view's origin becomes the centre of its near side.
void fit_parallel(inout View view, Range range) {
    if (range.low.x > range.high.x) {
        range = Range(vec3(0.0), vec3(1.0));
    }
    vec3 middle = (range.low + range.high) * 0.5;
    vec3 far = abs(view.origin);
    float rounding = ROUNDING * max(far.x, max(far.y, far.z));
    vec3 half_size = max((range.high - range.low) * 0.5 * MARGIN + rounding, vec3(1e-6));
    half_size.z = max(half_size.z, THINNEST * max(half_size.x, half_size.y));
    view.origin += view.right * middle.x + view.up * middle.y + view.forward * (middle.z - half_size.z);
    view.scale_x = 1.0 / half_size.x;
    view.scale_y = 1.0 / half_size.y;
    view.near = 0.0;
    view.far = 2.0 * half_size.z * view.far;
}

// Fits only the range of depths.
void fit_perspective(inout View view, Range range) {
    float high = max(range.high.z, 1e-3);
    float near = clamp(range.low.z - ROUNDING * high, high * view.near, high * 0.999);
    view.far = near + ((high - near) * MARGIN + ROUNDING * high) * view.far;
    view.near = near;
}

void fit(inout View view, Range range) {
    if (view.projection == VIEW_PARALLEL) {
        fit_parallel(view, range);
    } else {
        fit_perspective(view, range);
    }
}

// Narrows a view by a power of two, for a cascade in front of the camera. The camera is at one edge of the cascade and looks across it, but
// the cascade always stays within the full view. It moves in whole texels.
void narrow(inout View view, uint cascade) {
    float share = 1.0 / float(1u << cascade);
    vec2 whole = 1.0 / vec2(view.scale_x, view.scale_y), half_size = whole * share;
    vec3 offset = eye - view.origin;
    vec2 from = vec2(dot(offset, view.right), dot(offset, view.up));
    vec2 middle = from + half_size * vec2(dot(ahead, view.right), dot(ahead, view.up));
    middle = clamp(middle, half_size - whole, whole - half_size);
    vec2 texel = half_size * 2.0 / vec2(view.width, view.height);
    middle = round(middle / texel) * texel;
    view.origin += view.right * middle.x + view.up * middle.y;
    view.scale_x = 1.0 / half_size.x;
    view.scale_y = 1.0 / half_size.y;
}

void main() {
    uint map = gl_GlobalInvocationID.x;
    if (map >= map_count) {
        return;
    }
    Range casters = range_of(map, 0u), meshes = range_of(map, 3u);
    Map m = maps[map];
    if (only_meshes == 1u) {
        m.caster_view.origin = m.opaque.origin;
        fit(m.caster_view, meshes);
    } else {
        fit(m.caster_view, casters);
    }
    fit(m.opaque, meshes);
    if (map >= cascade_maps) {
        narrow(m.opaque, map / cascade_maps);
    }
    maps[map] = m;
}
