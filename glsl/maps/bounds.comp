#version 460
// Computes the bounds of the casters and of the meshes in each map's view. Twin: reference::twin::fit. Inputs: maps, with origin, axes and,
// in perspective, the scale already set; casters, triangles. Output: extents, relative to the volume's origin for casters and to the opaque
// view's origin for meshes. Invariant: the extents contain every sphere that the map can see, whatever the order of the atomics.
#include "maps/extents.glsl"
#include "maps/scene.glsl"

layout(local_size_x = 64) in;

// set 1: maps_bounds
layout(set = 1, binding = 0, scalar) buffer AllExtents { Extents extents[]; };

layout(push_constant, scalar) uniform BoundsPush {
    uint caster_count;
    uint triangle_count;
    uint threads;  // number of threads per map
    uint see_all;  // 1: cull nothing, since strands may cross a view that contains neither of their ends
};

shared uint low[6];
shared uint high[6];

// Whether a spot light or a face of a point light may see a sphere, given along the view's axes: false if the sphere is outside one of the
// pyramid's four planes.
bool sees(View view, vec3 centre, float radius) {
    float tangent = 1.0 / view.scale_x;
    float outside = max(abs(centre.x), abs(centre.y)) - tangent * centre.z;
    // Enlarged by an error bound for the rounding of the three coordinates.
    radius += 1e-5 * (abs(centre.x) + abs(centre.y) + abs(centre.z));
    return outside < radius * sqrt(1.0 + tangent * tangent) && centre.z + radius > 0.0;
}

// Bounds of all casters or meshes that one thread has seen. A thread collects many before it shares the bounds, since atomics on shared
// memory are slow.
struct Seen {
    uvec3 low;
    uvec3 high;
};

void include(inout Seen seen, vec3 centre, float radius) {
    vec3 from = centre - radius, to = centre + radius;
    seen.low = min(seen.low, uvec3(float_order(from.x), float_order(from.y), float_order(from.z)));
    seen.high = max(seen.high, uvec3(float_order(to.x), float_order(to.y), float_order(to.z)));
}

void share(Seen seen, uint first) {
    for (uint axis = 0u; axis < 3u; ++axis) {
        atomicMin(low[first + axis], seen.low[axis]);
        atomicMax(high[first + axis], seen.high[axis]);
    }
}

void main() {
    uint map = gl_WorkGroupID.z;
    if (gl_LocalInvocationIndex < 6u) {
        low[gl_LocalInvocationIndex] = 0xFFFFFFFFu;
        high[gl_LocalInvocationIndex] = 0u;
    }
    barrier();
    View view = maps[map].caster_view, opaque = maps[map].opaque;
    bool all = view.projection == VIEW_PARALLEL || see_all == 1u;
    Seen casters_seen = Seen(uvec3(0xFFFFFFFFu), uvec3(0u)), meshes_seen = casters_seen;
    for (uint i = gl_GlobalInvocationID.x; i < caster_count; i += threads) {
        Caster caster = casters[i];
        if (caster.radius == 0.0) {
            continue;  // an unused entry: only the device knows how many casters there are
        }
        vec3 start = view_axes(view, caster.position - view.origin);
        if (all || sees(view, start, caster.radius)) {
            include(casters_seen, start, caster.radius);
        }
        if (caster_is_strand(caster)) {
            include(casters_seen, view_axes(view, caster.position + caster.axis - view.origin), caster.radius);
        }
    }
    for (uint i = gl_GlobalInvocationID.x; i < triangle_count; i += threads) {
        for (uint corner = 0u; corner < 3u; ++corner) {
            include(meshes_seen, view_axes(opaque, triangles[i].corners[corner] - opaque.origin), 0.0);
        }
    }
    share(casters_seen, 0u);
    share(meshes_seen, 3u);
    barrier();
    if (gl_LocalInvocationIndex < 6u) {
        uint i = gl_LocalInvocationIndex;
        atomicMin(extents[map].low[i], low[i]);
        atomicMax(extents[map].high[i], high[i]);
    }
}
