// A volume marched along a pixel's ray, front to back, in two steps of equal length per cell of its field. A step's optical depth is the
// integral of the trilinear densities, by Gauss-Legendre quadrature with two points; the step is lit at its midpoint. Must be declared
// before inclusion: camera, and everything that shading/caster_light.glsl needs. Twin: reference::truth::picture.
#ifndef CONSUME_VOLUME_GLSL
#define CONSUME_VOLUME_GLSL
#include "shading/caster_light.glsl"
#include "world/field.glsl"

// set 3: picture_fields
layout(set = 3, binding = 0, scalar) readonly buffer FieldPlaces { FieldPlace field_places[]; };
layout(set = 3, binding = 1, scalar) readonly buffer FieldSlots { FieldSlot field_slots[]; };
layout(set = 3, binding = 2, scalar) readonly buffer FieldSamples { float field_samples[]; };

layout(push_constant, scalar) uniform VolumePush {
    uint volume;
    vec3 ratio;  // ratio of the volume's extinctions, if casters have different ratios
};

// Number of steps per cell. Twin: STEPS.
const uint STEPS = 2u;
// The march stops when the transmittance falls below this value, which bounds the error relative to the light behind.
const float LEAST_LEFT = 1e-4;

// Finds the first sample of a block among those of all fields; false if the block is empty.
bool field_block(FieldPlace place, ivec3 block, out uint first) {
    if (any(lessThan(block, ivec3(0)))) {
        return false;
    }
    uint slot = field_hash(uvec3(block));
    for (uint i = 0u; i <= place.last_slot; ++i, ++slot) {
        FieldSlot found = field_slots[place.first_slot + (slot & place.last_slot)];
        if (found.number == 0u) {
            return false;
        }
        if (found.block == uvec3(block)) {
            first = FIELD_SAMPLES * (place.first_block + found.number - 1u);
            return true;
        }
    }
    return false;
}

// Accumulated along the march.
vec3 scattered = vec3(0.0);
vec3 transmittance = vec3(1.0);

// Whether the transmittance is high enough for light from farther back to be visible.
bool is_seen() { return max(transmittance.x, max(transmittance.y, transmittance.z)) > LEAST_LEFT; }

// Marches one cell from z.x to z.y. `corners`: densities. `within`: the ray in samples, relative to the cell's minimum corner; `ray`: in
// world units.
void march_cell(FieldPlace place, Ray ray, Ray within, float corners[8], vec2 z) {
    float reach = 0.5 * (z.y - z.x) / float(STEPS);
    float scale = place.extinction * length(ray.direction) * reach;
    for (uint i = 0u; i < STEPS; ++i) {
        float middle = z.x + float(2u * i + 1u) * reach, beside = reach * 0.57735027;
        vec3 before = within.origin + (middle - beside) * within.direction, behind = within.origin + (middle + beside) * within.direction;
        float depth = scale * (field_density(corners, clamp(before, 0.0, 1.0)) + field_density(corners, clamp(behind, 0.0, 1.0)));
        if (depth <= 0.0) {
            continue;
        }
        vec3 position = ray.origin + middle * ray.direction;
        light_footprint(pixel_side(camera, middle));
        vec3 left = transmittance * exp(-depth * (CASTER_ROOM == 0u ? extinction_ratio() : ratio));
        Caster none = Caster(position, 0.0, vec3(0.0), 0.0);
        scattered += (transmittance - left) * shade_caster(place.color, caster_light(none, position));
        transmittance = left;
    }
}

// Marches the cells of a block from z.x to z.y. `within`: the ray in samples, relative to the block's minimum corner.
void march_block(FieldPlace place, Ray ray, Ray within, uint first, vec2 z) {
    FieldWalk walk = field_walk(within, z);
    ivec3 cube;
    // At least as many cells as a ray can cross in 8³, and some more for rounding.
    for (uint i = 0u; i < 32u && is_seen() && field_next(within, walk, cube, z); ++i) {
        // At the block's ends, rounding may lead into a cell of a neighbouring block.
        uvec3 at = uvec3(clamp(cube, ivec3(0), ivec3(FIELD_SIDE - 1)));
        float corners[8], most = 0.0;
        for (uint corner = 0u; corner < 8u; ++corner) {
            uvec3 sample_at = at + uvec3(corner & 1u, corner >> 1u & 1u, corner >> 2u);
            corners[corner] = field_samples[first + (sample_at.z * FIELD_CORNERS + sample_at.y) * FIELD_CORNERS + sample_at.x];
            most = max(most, corners[corner]);
        }
        if (most > 0.0 && z.y > z.x) {
            march_cell(place, ray, Ray(within.origin - vec3(at), within.direction), corners, z);
        }
    }
}

// Marches the volume along the ray through a position in the picture, up to the mesh at `farthest`. False if the ray misses the volume.
bool march(vec2 pixel, float farthest) {
    FieldPlace place = field_places[volume];
    Ray ray = view_ray(camera, pixel);
    Ray within = field_ray(place, ray);
    vec2 z = vec2(camera.near, farthest);
    if (!field_clipped(within, place.size, z)) {
        return false;
    }
    Ray blocks = Ray(within.origin / float(FIELD_SIDE), within.direction / float(FIELD_SIDE));
    FieldWalk walk = field_walk(blocks, z);
    uint most = uint(dot(place.size, vec3(1.0 / float(FIELD_SIDE)))) + 8u;
    ivec3 block;
    for (uint i = 0u; i < most && is_seen() && field_next(blocks, walk, block, z); ++i) {
        uint first;
        if (z.y > z.x && field_block(place, block, first)) {
            march_block(place, ray, Ray(within.origin - vec3(FIELD_SIDE * block), within.direction), first, z);
        }
    }
    return true;
}
#endif
