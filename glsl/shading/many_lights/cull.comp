#version 460
// Finds the lights that may reach the surfaces in a tile of 16 × 16 pixels: lights whose spheres overlap the space between the four planes
// through the tile's edges, within the tile's range of z. A light of unlimited range is always found. Sources: Olsson and Assarsson 2011;
// Andersson 2009. A tile's list has one bit per light, so that its order is fixed and it cannot overflow. Twin:
// reference::twin::many_lights::cull. Inputs: lights, this frame, albedo (0 in alpha: sky), normal, z. Outputs: a tile's words; each
// pixel's surface. Invariant: a light that reaches a pixel is in its tile's words, however the shader that shades the pixel rounds.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/picture_set.glsl"
#include "shading/many_lights/geometry.glsl"

layout(local_size_x = 128) in;

SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES

// Largest number of words per tile, for 1,024 lights.
const uint MOST_WORDS = 32u;

// Rounding error bounds: FAR_ROUNDING as a fraction of coordinates, NEAR_ROUNDING as a factor in lies_outside.
const float FAR_ROUNDING = 2e-6;
const float NEAR_ROUNDING = 1.0001;

shared uint least_z, greatest_z;
shared uint found[MOST_WORDS];

// Whether a sphere with 1 / radius² = `falloff` is outside a plane. `outside`: distance of the sphere's centre from the plane, times the
// length of the plane's normal. `square`: that length squared. Needs no division; NaN counts as not outside.
bool lies_outside(float outside, float square, float falloff) {
    precise float left = outside * outside * falloff;
    return outside > 0.0 && left > square * NEAR_ROUNDING;
}

bool reaches(Light light, uvec2 low, uvec2 high, float near, float far) {
    // A virtual light has unlimited range.
    float falloff = light.kind == LIGHT_VIRTUAL ? 0.0 : light.falloff;
    View camera = frames[0].camera;
    precise vec3 offset = light.position - camera.origin;
    precise float x = offset.x * camera.right.x + offset.y * camera.right.y + offset.z * camera.right.z;
    precise float y = offset.x * camera.up.x + offset.y * camera.up.y + offset.z * camera.up.z;
    precise float z = offset.x * camera.forward.x + offset.y * camera.forward.y + offset.z * camera.forward.z;
    precise float slack = (abs(light.position.x) + abs(light.position.y) + abs(light.position.z) + abs(camera.origin.x)
                         + abs(camera.origin.y) + abs(camera.origin.z) + far) * FAR_ROUNDING;
    precise float before = near - z - slack, behind = z - far - slack;
    bool outside = lies_outside(before, 1.0, falloff) || lies_outside(behind, 1.0, falloff);
    // Planes through the camera and the sides of the tile: two across the picture, two down.
    for (uint axis = 0u; axis < 2u; ++axis) {
        precise float wide = float(size[axis]);
        precise float scale = (axis == 0u ? camera.scale_x : camera.scale_y) * wide;
        precise float at = (axis == 0u ? x : y) * scale;
        for (uint side = 0u; side < 2u; ++side) {
            precise float slope = 2.0 * float(side == 0u ? low[axis] : high[axis]) - wide;
            precise float off = side == 0u ? slope * z - at : at - slope * z;
            precise float square = scale * scale + slope * slope;
            precise float reduced = off - slack * (abs(scale) + abs(slope));
            outside = outside || lies_outside(reduced, square, falloff);
        }
    }
    return !outside;
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    uvec2 tile = gl_WorkGroupID.xy;
    if (thread == 0u) {
        least_z = 0xffffffffu;
        greatest_z = 0u;
    }
    if (thread < MOST_WORDS) {
        found[thread] = 0u;
    }
    barrier();
    for (uint i = thread; i < TILE * TILE; i += gl_WorkGroupSize.x) {
        uvec2 pixel = tile * TILE + uvec2(i % TILE, i / TILE);
        if (any(greaterThanEqual(pixel, size))) {
            continue;
        }
        bool is_sky = texelFetch(albedos, ivec2(pixel), 0).a == 0.0;
        uint z = is_sky ? 0u : floatBitsToUint(texelFetch(distances, ivec2(pixel), 0).r);
        uint normal = is_sky ? 0u : pack_normal(texelFetch(normals, ivec2(pixel), 0).xyz);
        geometry[pixel_index(pixel)] = uvec2(z, normal);
        if (!is_sky) {
            // Non-negative floats compare like their bits.
            atomicMin(least_z, z);
            atomicMax(greatest_z, z);
        }
    }
    barrier();
    if (least_z <= greatest_z) {
        uvec2 low = tile * TILE, high = min(low + TILE, size);
        for (uint i = thread; i < min(lights.length(), 32u * words); i += gl_WorkGroupSize.x) {
            if (reaches(lights[i], low, high, uintBitsToFloat(least_z), uintBitsToFloat(greatest_z))) {
                atomicOr(found[i / 32u], 1u << (i % 32u));
            }
        }
    }
    barrier();
    if (thread < words) {
        masks[tile_words(tile) + thread] = found[thread];
    }
}
