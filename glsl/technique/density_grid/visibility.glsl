// Density grid look-up: how much of light `light` reaches `position`, 0 to 1. Smoke and hair absorb light in the voxels along the ray to
// the light; meshes block it according to the light's opaque map. Sources: Amanatides and Woo 1987 (every voxel); Novák et al. 2014 (ratio
// tracking); mean directions of strands are ours. Twins: reference::twin::media, reference::twin::soft.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  the grid (grid/grid.glsl)
//   binding 2  the grid's media (grid/media.glsl)
//   binding 3  the media's bits (grid/media.glsl)
//   binding 4  directions of the strands in each voxel, or normals of the sheets (grid/directions.glsl), or any buffer if DIRECTION is false
//   binding 5  the greatest value of any voxel, in units of media, or any buffer if MARCH is not 2
//   binding 6  maps of all lights (world/light.glsl)
//   binding 7  the opaque map (maps/look_up_set.glsl, binding 2)
// flat: bindings 176, constants 352: GRID_SIZE MARCH MARCH_STEPS DIRECTION NORMAL_BIAS FACING
#include "grid/directions.glsl"
#include "grid/media.glsl"
#include "grid/way.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityGrid { Grid visibility_grid; };
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityMedia { uint visibility_media[]; };
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityMediaBits { uint visibility_media_bits[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityDirections { int visibility_directions[]; };
layout(set = GOBO_SET, binding = 5, scalar) readonly buffer VisibilityMost { uint visibility_most; };
layout(set = GOBO_SET, binding = 6, scalar) readonly buffer VisibilityMaps { Map visibility_maps[]; };
layout(set = GOBO_SET, binding = 7) uniform sampler2D visibility_opaque;

#include "grid/meshes.glsl"

// Voxels per side.
CONSTANT(uint, GRID_SIZE, 128u)
// 0: every voxel along the ray. 1: even steps. 2: random positions.
CONSTANT(uint, MARCH, 0u)
// Number of even steps.
CONSTANT(uint, MARCH_STEPS, 64u)
// Whether strands absorb less of light that runs along them than of light that crosses them.
CONSTANT(bool, DIRECTION, false)

const uint MARCH_EVEN = 1u;
const uint MARCH_RATIO = 2u;

// Set by a shader that dithers, from 0 to 1: x is the position of a sample within each step; x to z seed the random positions. Below 0,
// samples are in the middle of the steps, and the random positions depend only on the point that is looked up.
#define TECHNIQUE_DITHERS
vec3 look_up_dither = vec3(-1.0);

// Direction of the ray to the light, unit length.
vec3 look_up_towards = vec3(0.0);

float media_towards(float sum, uvec3 voxel) {
    if (!DIRECTION) {
        return sum;
    }
    uint at = 6u * media_at(GRID_SIZE, voxel);
    vec3 diagonal = vec3(visibility_directions[at], visibility_directions[at + 1u], visibility_directions[at + 2u]);
    vec3 beside = vec3(visibility_directions[at + 3u], visibility_directions[at + 4u], visibility_directions[at + 5u]);
    return directed(sum, diagonal * (1.0 / DIRECTION_UNITS), beside * (1.0 / DIRECTION_UNITS), look_up_towards);
}

#include "grid/soft.glsl"

// Returns a seed from the point, the light and the shader's dither.
uint ratio_seed(uint light, vec3 position) {
    uvec3 bits = floatBitsToUint(position), dither = floatBitsToUint(look_up_dither);
    uint seed = ratio_hash(bits.x ^ ratio_hash(bits.y ^ ratio_hash(bits.z ^ ratio_hash(light))));
    return ratio_hash(seed ^ dither.x ^ ratio_hash(dither.y ^ ratio_hash(dither.z)));
}

float light_visibility(uint light, vec3 position) {
    float left = meshes_leave(light, position);
    vec3 from, way;
    if (left == 0.0 || !grid_way(visibility_grid, visibility_lights[light], position, from, way)) {
        return left;
    }
    look_up_towards = way / max(length(way), 1e-30);
    if (MARCH == MARCH_RATIO) {
        float most = float(visibility_most) * ((DIRECTION ? ACROSS : 1.0) / MEDIA_UNITS);
        return left * media_ratio(from, way, most, ratio_seed(light, position));
    }
    float offset = look_up_dither.x < 0.0 ? 0.5 : look_up_dither.x;
    return left * exp(-(MARCH == MARCH_EVEN ? media_soft_steps(from, way, MARCH_STEPS, offset) : media_exact(from, way)));
}
