// The segment from a point to a light through a grid that holds only smoke and hair: receivers need no offset from their own surface.
// Source: ours.
#ifndef GRID_WAY_GLSL
#define GRID_WAY_GLSL
#include "grid/grid.glsl"
#include "world/light.glsl"

// `from` and `way` are in voxels; the segment ends at the light, or outside the grid. False for NaN, which is in no voxel.
bool grid_way(Grid grid, Light light, vec3 position, out vec3 from, out vec3 way) {
    from = (position - grid.origin) * grid.per_unit;
    float size = float(grid.size);
    way = light.kind == LIGHT_DIRECTIONAL ? -light.direction * (2.0 * size + distance(from, vec3(0.5 * size)))
                                          : (light.position - position) * grid.per_unit;
    return all(lessThan(abs(from), vec3(1e7)));
}
#endif
