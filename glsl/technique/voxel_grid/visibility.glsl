// Voxel grid look-up: 0 if an occupied voxel lies between `position` and light `light` (with CELL, an occupied cell of its mask or a
// triangle of its list), else 1. Sources: Pestana 2015 (even steps); Amanatides and Woo 1987 (every voxel). Twins:
// reference::twin::grid::Bits, reference::twin::masks::Masks.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  the grid (grid/grid.glsl)
//   binding 2  the grid's bits
//   binding 3  the grid's media (grid/media.glsl), or any buffer if MEDIA is false
//   binding 4  the media's bits (grid/media.glsl), or any buffer if MEDIA is false
//   binding 5  the grid's cells (grid/cells.glsl) if CONE is true, the grid's lists (grid/lists/place.glsl) if CELL is 2, else any buffer
//   binding 6  triangles (world/triangle_rows.glsl)
//   binding 7  the grid's masks (grid/masks.glsl), or any buffer if CELL is not 1
// flat: bindings 64, constants 128: GRID_SIZE MARCH_STEPS MARCH_OFFSET MEDIA CONE CONE_SLOPE CELL BIAS ALPHA_FIRST
#include "world/colors.glsl"
#include "world/light.glsl"
#include "grid/grid.glsl"
#include "world/triangle_rows.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityGrid { Grid visibility_grid; };
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityBits { uint visibility_bits[]; };
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityMedia { uint visibility_media[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityMediaBits { uint visibility_media_bits[]; };
layout(set = GOBO_SET, binding = 5, scalar) readonly buffer VisibilityCells { uint visibility_cells[]; };
layout(set = GOBO_SET, binding = 6, scalar) readonly buffer VisibilityTriangles { TriangleRows visibility_triangles[]; };
layout(set = GOBO_SET, binding = 7, scalar) readonly buffer VisibilityMasks { uint visibility_masks[]; };

// Voxels per side.
CONSTANT(uint, GRID_SIZE, 256u)
// Shadow casters. 0: voxels; 1: the cells of their masks; 2: the triangles listed in them.
CONSTANT(uint, CELL, 0u)

#include "grid/march.glsl"
#include "grid/march_cone.glsl"
#include "grid/march_triangles.glsl"

// Voxels absorb the same in every direction.
float media_towards(float sum, uvec3 voxel) { return sum; }

#include "grid/march_media.glsl"

// Number of even steps; 0: every voxel.
CONSTANT(uint, MARCH_STEPS, 0u)
// Position of the sample within each step, 0 to 1.
CONSTANT(float, MARCH_OFFSET, 0.5)

// Set by a shader that dithers, from 0 to 1: x is the position of a sample within each step; y and z shift the receiver across a cell.
// Below 0, samples are at MARCH_OFFSET, and the receiver is not moved.
#define TECHNIQUE_DITHERS
vec3 look_up_dither = vec3(-1.0);
// Whether there is smoke or hair.
CONSTANT(bool, MEDIA, false)

// Whether meshes are looked up with a cone.
CONSTANT(bool, CONE, false)
// Growth of the cone's radius per unit of its length.
CONSTANT(float, CONE_SLOPE, 0.0)
// Distance, in cells, by which a receiver is moved along its ray once it is off its surface.
CONSTANT(float, BIAS, 2.0)

// Additional distance, in cells, by which a receiver is moved out of its surface's cells.
const float RECEIVER_MARGIN = 1e-3;

// Returns a cell's side, in world units.
float cell_side() { return visibility_grid.voxel / float(1u << CELL_SHIFT); }

// Moves a surface point along its normal, by a cell's extent in that direction, so that it is in no cell that the surface occupies. The
// moved point's cell then lies entirely in front of the surface, and so does every cell that a ray away from the surface enters. A cone
// also reads the neighbours of its voxels; for a cone the point is moved half as far again. If triangles are tested, a virtual light is
// moved off its own triangle by the rounding error alone.
vec3 off_the_surface(vec3 position, vec3 normal) {
    float cells = (CONE ? 1.5 : 1.0) * (abs(normal.x) + abs(normal.y) + abs(normal.z)) + RECEIVER_MARGIN;
    return position + normal * (cells * (CELL == CELL_TRIANGLES ? grid_rounding(visibility_grid) : cell_side()));
}

// Returns how far a receiver is moved along a ray, as a share of the ray's length.
float share_along(vec3 way) { return min(1.0, BIAS * cell_side() / max(length(way), 1e-30)); }

// Returns where a ray to a light ends. A virtual light sits on a surface, so the ray ends off that surface, by the distance that a receiver
// is moved off its own surface.
vec3 light_end(Light l) {
    return l.kind == LIGHT_VIRTUAL ? off_the_surface(l.position, l.direction) : l.position;
}

#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    Light l = visibility_lights[light];
    vec3 end = light_end(l), towards = l.kind == LIGHT_DIRECTIONAL ? -l.direction : end - position;
    // A point of a closed mesh that faces away from the light is dark. It is looked up in its own voxel, which is occupied; the voxel
    // beside it may be empty. Lists of triangles do not need this.
    if (CELL == CELL_TRIANGLES || !CONE && dot(normal, towards) <= 0.0) {
        return position;
    }
    vec3 receiver = off_the_surface(position, normal);
    if (MARCH_STEPS == 0u && look_up_dither.x >= 0.0) {
        // Dithered: the receiver moves along the surface within a cell's width, which blurs the edges of cells.
        vec3 axis = abs(normal.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
        vec3 across = normalize(cross(normal, axis));
        vec2 by = (look_up_dither.yz - 0.5) * cell_side();
        receiver += by.x * across + by.y * cross(normal, across);
    }
    if (l.kind == LIGHT_DIRECTIONAL) {
        return receiver + towards * (BIAS * cell_side());
    }
    return receiver + (end - receiver) * share_along(end - receiver);
}

float light_visibility(uint light, vec3 position) {
    look_up_meshes = 1.0;
    Light l = visibility_lights[light];
    vec3 from = (position - visibility_grid.origin) * visibility_grid.per_unit;
    // NaN has no voxel.
    if (!(all(lessThan(abs(from), vec3(1e7))))) {
        return 1.0;
    }
    float size = float(GRID_SIZE);
    vec3 way = -l.direction * (2.0 * size + distance(from, vec3(0.5 * size)));
    if (l.kind != LIGHT_DIRECTIONAL) {
        way = light_end(l) - position;
        way *= visibility_grid.per_unit * (l.kind == LIGHT_VIRTUAL ? 1.0 - share_along(way) : 1.0);
    }
    float offset = look_up_dither.x < 0.0 ? MARCH_OFFSET : look_up_dither.x;
    float left = 1.0;
    if (CELL == CELL_TRIANGLES) {
        bool is_far = l.kind == LIGHT_DIRECTIONAL;
        vec3 direction = is_far ? -l.direction : light_end(l) - position;
        left = march_triangles(from, way, position, direction, is_far ? FARTHEST : 1.0) ? 0.0 : 1.0;
    } else if (CONE) {
        left = march_cone(from, way, CONE_SLOPE);
    } else {
        left = (MARCH_STEPS == 0u ? march_exact(from, way) : march_steps(from, way, MARCH_STEPS, offset)) ? 0.0 : 1.0;
    }
    look_up_meshes = left;
    if (left == 0.0 || !MEDIA) {
        return left;
    }
    float taken = MARCH_STEPS == 0u ? media_exact(from, way) : media_steps(from, way, MARCH_STEPS, offset);
    return left * exp(-taken);
}
