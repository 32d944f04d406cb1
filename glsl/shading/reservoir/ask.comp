#version 460
// shading=reservoir, first pass. Each pixel draws a few lights at random and keeps one, in proportion to the light that the pixel would
// reflect from it without shadows. The pixel looks up that light's visibility, then resamples it with the light that its surface kept in
// the previous frame. Sources: Bitterli et al. 2020, Spatiotemporal reservoir resampling (candidates, reuse of visibility, reuse over time
// without bias); Talbot et al. 2005, Importance resampling. Twin: reference::twin::reservoir. Inputs: lights, camera, albedo, normal, z,
// the technique, lights and surfaces of the previous frame. Outputs: the light that each pixel reflects, times its weight; the light that
// the pixel keeps. Invariant: over all random numbers a pixel's mean is the light that it reflects from all lights. So a kept light is
// weighted by the number of frames that could have kept it. Counting these needs another look-up if the earlier pixel saw a different point
// of the surface.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/picture_set.glsl"
#include "shading/surface.glsl"
#include "shading/reservoir/random.glsl"
#include "visibility.glsl"
#include "query/colored.glsl"
#include "world/light.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// A light that a pixel keeps, and the pixel's surface. Twin: shading::ReservoirData.
struct Reservoir {
    uint light;
    float weight;   // factor that turns the kept light's contribution into an unbiased estimate of the sum over all lights; 0: no light
    uint frames;    // number of frames that the light represents, and CLOSED
    float z;        // 0 in the sky
    vec3 normal;
};

PICTURE_LIGHTS
PICTURE_CAMERA
SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES
// set 3: reservoir_kept
layout(set = 3, binding = 0, scalar) writeonly buffer Estimates { vec3 estimates[]; };
layout(set = 3, binding = 1, scalar) writeonly buffer Reservoirs { Reservoir reservoirs[]; };
layout(set = 3, binding = 2, scalar) readonly buffer ReservoirsBefore { Reservoir reservoirs_before[]; };
layout(set = 3, binding = 3, scalar) readonly buffer CamerasBefore { View before; };

layout(push_constant, scalar) uniform ReservoirPush {
    uint frame;       // number of the frame, counted from the first
    uint has_before;
    float edge;       // how far a point may be off a surface and still belong to it, world units per unit of z
};

#include "shading/surface_light.glsl"

// Number of lights that a pixel draws per frame, and largest number of frames that a reservoir represents. Twins: CANDIDATES, MOST_FRAMES.
const uint CANDIDATES = 16u;
const uint MOST_FRAMES = 20u;
const uint CLOSED = 1u << 31;
// Two normals with at least this cosine belong to one surface: 26°, as in shading/packed_normal.glsl.
const float SAME_SURFACE = 0.9;

struct Seen {
    vec3 position;
    vec3 normal;
    bool is_closed;
};

// Light that a surface reflects from an unshadowed light, as luminance.
float target(uint light, Seen at) {
    return dot(light_on_surface(lights[light], at.position, at.normal, vec3(1.0)), vec3(0.2126, 0.7152, 0.0722));
}

vec3 visibility(uint light, Seen at) {
    return colored(surface_visibility(light, lights[light], at.position, at.normal, at.is_closed));
}

// Finds the pixel that saw this surface in the previous frame: its reservoir `old` and its surface `there`. False if there is none.
bool seen_before(Seen here, out Reservoir old, out Seen there) {
    old = Reservoir(0u, 0.0, 0u, 0.0, vec3(0.0));
    there = here;
    float ahead = dot(here.position - before.origin, before.forward);
    vec2 texel = view_project(before, here.position).xy, size = vec2(before.width, before.height);
    if (has_before == 0u || !(ahead > before.near) || any(lessThan(texel, vec2(0.0))) || !all(lessThan(texel, size))) {
        return false;
    }
    uvec2 was = min(uvec2(texel), uvec2(before.width, before.height) - 1u);
    old = reservoirs_before[was.y * before.width + was.x];
    if (old.z == 0.0 || dot(old.normal, here.normal) < SAME_SURFACE) {
        return false;
    }
    vec3 position = surface_position(surface_ray(before, vec2(was) + 0.5), old.z);
    there = Seen(position, old.normal, (old.frames & CLOSED) != 0u);
    return abs(dot(here.normal, here.position - position)) <= edge * ahead;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, uvec2(camera.width, camera.height)))) {
        return;
    }
    uint index = pixel.y * camera.width + pixel.x;
    if (texelFetch(albedos, ivec2(pixel), 0).a == 0.0) {
        estimates[index] = vec3(0.0);
        reservoirs[index] = Reservoir(0u, 0.0, 0u, 0.0, vec3(0.0));
        return;
    }
    float z = texelFetch(distances, ivec2(pixel), 0).r;
    vec4 facing = texelFetch(normals, ivec2(pixel), 0);
    Seen here = Seen(surface_position(surface_ray(camera, vec2(pixel) + 0.5), z), facing.xyz, facing.w != 0.0);
    // The earlier surface is about equally far away, so its look-ups have this footprint too.
    light_footprint(pixel_side(camera, z));
    uint seed = pixel_seed(index, frame), count = lights.length();

    uint light = 0u;
    float own = 0.0;
    precise float sum = 0.0;
    for (uint i = 0u; i < CANDIDATES && count > 0u; ++i) {
        uint candidate = candidate_light(random_bits(seed, 2u * i), i, CANDIDATES, count);
        float one = target(candidate, here);
        sum += one;
        if (random_share(random_bits(seed, 2u * i + 1u)) * sum < one) {
            light = candidate;
            own = one;
        }
    }
    vec3 visible = own > 0.0 ? visibility(light, here) : vec3(0.0);
    float weight = any(greaterThan(visible, vec3(0.0))) ? sum * (float(count) / float(CANDIDATES)) / own : 0.0;

    uint frames = 1u;
    Reservoir old;
    Seen there;
    if (seen_before(here, old, there)) {
        uint frames_before = min(old.frames & ~CLOSED, MOST_FRAMES);
        frames += frames_before;
        float other = old.weight > 0.0 ? target(old.light, here) : 0.0;
        precise float old_part = float(frames_before) * other * old.weight, all = own * weight + old_part;
        bool is_old = random_share(random_bits(seed, 2u * CANDIDATES)) * all < old_part;
        if (is_old) {
            light = old.light;
            own = other;
            visible = visibility(light, here);
        }
        // Number of the counted frames, including this one, that could have kept this light.
        uint could = is_old ? frames_before : 0u;
        could += any(greaterThan(visible, vec3(0.0))) ? 1u : 0u;
        if (!is_old && any(greaterThan(visible, vec3(0.0)))) {
            bool same_place = there.position == here.position && there.normal == here.normal;
            bool reached = same_place || target(light, there) > 0.0 && any(greaterThan(visibility(light, there), vec3(0.0)));
            could += reached ? frames_before : 0u;
        }
        weight = any(greaterThan(visible, vec3(0.0))) ? all / (float(could) * own) : 0.0;
    }
    vec3 turned = weight > 0.0 ? weight * light_on_surface(lights[light], here.position, here.normal, visible) : vec3(0.0);
    estimates[index] = turned;
    reservoirs[index] = Reservoir(light, weight, frames | (here.is_closed ? CLOSED : 0u), z, here.normal);
}
