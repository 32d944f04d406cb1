#version 460
// Bounds of meshes, smoke and hair along the world's axes. Source: ours. Inputs: triangles, casters. Outputs: grid.low, grid.high. Twin:
// reference::twin::grid::bounds.
layout(local_size_x = 64) in;
#include "grid/build.glsl"
#include "world/caster.glsl"

// set 1: grid_casters
layout(set = 1, binding = 0, scalar) readonly buffer BoundsCasters { Caster casters[]; };

shared uint low[3];
shared uint high[3];

uvec3 least = uvec3(0xFFFFFFFFu);
uvec3 most = uvec3(0u);

uvec3 orders(vec3 place) { return uvec3(float_order(place.x), float_order(place.y), float_order(place.z)); }

void include(vec3 centre, float radius) {
    least = min(least, orders(centre - radius));
    most = max(most, orders(centre + radius));
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    if (thread < 3u) {
        low[thread] = 0xFFFFFFFFu;
        high[thread] = 0u;
    }
    barrier();
    for (uint i = gl_GlobalInvocationID.x; i < triangle_count; i += threads) {
        for (uint c = 0u; c < 3u; ++c) {
            include(triangles[i].corners[c], 0.0);
        }
    }
    for (uint i = gl_GlobalInvocationID.x; i < caster_count; i += threads) {
        if (casters[i].radius == 0.0) {
            continue;  // an unused entry: only the device knows how many casters there are
        }
        include(casters[i].position, casters[i].radius);
        include(casters[i].position + caster_axis(casters[i]), casters[i].radius);
    }
    for (uint axis = 0u; axis < 3u; ++axis) {
        atomicMin(low[axis], least[axis]);
        atomicMax(high[axis], most[axis]);
    }
    barrier();
    if (thread < 3u) {
        atomicMin(grid.low[thread], low[thread]);
        atomicMax(grid.high[thread], high[thread]);
    }
}
