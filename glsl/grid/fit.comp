#version 460
// Places the grid: a cube about all casters with a margin of one voxel on each side, or a wider margin if the grid has more voxels per side
// than `fitted`. One thread. Source: ours. Input: grid.low, grid.high. Output: the grid's other fields.
// Twin: reference::twin::grid::Place::about.
layout(local_size_x = 1) in;
#include "grid/build.glsl"

void main() {
    bool empty = grid.low[0] > grid.high[0];
    vec3 low = vec3(0.0), high = vec3(0.0);
    for (uint axis = 0u; axis < 3u && !empty; ++axis) {
        low[axis] = float_of_order(grid.low[axis]);
        high[axis] = float_of_order(grid.high[axis]);
    }
    vec3 extent = high - low, middle = 0.5 * (low + high), far = max(abs(low), abs(high));
    // Even a single point gets a grid whose voxels are distinguishable in floats.
    float least = max(1.0, max(far.x, max(far.y, far.z))) * 1e-3;
    float widest = max(max(extent.x, max(extent.y, extent.z)), least);
    grid.voxel = widest / float(fitted - 2u);
    grid.per_unit = float(fitted - 2u) / widest;
    grid.origin = middle - 0.5 * float(grid.size) * grid.voxel;
}
