#version 460
// How far the meshes reach along the world's axes. Source: ours. Input: triangles. Output: grid.low, grid.high.
// Twin: reference::twin::grid::bounds.
layout(local_size_x = 64) in;
#include "grid/build.glsl"

shared uint low[3];
shared uint high[3];

void main() {
    uint thread = gl_LocalInvocationIndex;
    if (thread < 3u) {
        low[thread] = 0xFFFFFFFFu;
        high[thread] = 0u;
    }
    barrier();
    uvec3 least = uvec3(0xFFFFFFFFu), most = uvec3(0u);
    for (uint i = gl_GlobalInvocationID.x; i < triangle_count; i += threads) {
        for (uint c = 0u; c < 3u; ++c) {
            vec3 corner = triangles[i].corners[c];
            uvec3 order = uvec3(float_order(corner.x), float_order(corner.y), float_order(corner.z));
            least = min(least, order);
            most = max(most, order);
        }
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
