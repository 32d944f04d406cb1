#version 460
// Turns lights in the caller's buffer into the world's lights, one thread per light. The host has already set each light's kind and maps. A
// light past the count, or with a number that is not finite or out of range, keeps its old position and goes dark. Source: ours. Inputs:
// the caller's buffer, the buffer of the count, lights. Outputs: lights, the counts of lights. Twin: reference::twin::gather::light.
layout(local_size_x = 64) in;
#include "world/gather.glsl"
#include "world/light.glsl"

layout(push_constant, scalar) uniform LightsPush {
    uint slots;     // number of lights to write
    uint most;      // largest number of the caller's lights to read
    uint count_at;  // word of `counts` that holds the count; NOWHERE: `most` is the count
    uint start;     // word of the first light
    uint stride;
    uint position;  // offset within a light, in words
    uint direction;
    uint radiance;
    uint radius;  // NOWHERE: all have the radius radius_is
    float radius_is;
    uint cos_cone;
    float cos_cone_is;
};

// set 0: gather_lights
layout(set = 0, binding = 0, scalar) readonly buffer GatherTheirs { uint theirs[]; };
layout(set = 0, binding = 1, scalar) readonly buffer GatherCounts { uint counts[]; };
layout(set = 0, binding = 2, scalar) buffer GatherLights { Light lights[]; };
layout(set = 0, binding = 3, scalar) buffer GatherCounted { GatherTotals counted; };

// Tolerance of a unit vector's squared length around 1. Twin: UNIT.
const float UNIT = 2e-3;
// For a smaller radius 1 / radius² is not a finite float; for a larger one it is 0. Twins: LEAST_RADIUS, MOST_RADIUS.
const float LEAST_RADIUS = 1e-18;
const float MOST_RADIUS = 1e18;
// Cosine of half the widest cone angle, 170°. Twin: WIDEST.
const float WIDEST = 0.0871557;

uvec3 three(uint at) { return uvec3(theirs[at], theirs[at + 1u], theirs[at + 2u]); }

bool is_unit(uvec3 bits) {
    vec3 v = uintBitsToFloat(bits);
    return is_finite(bits) && abs(dot(v, v) - 1.0) <= UNIT;
}

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    uint asked = count_at == NOWHERE ? most : counts[count_at];
    if (i == 0u) {
        counted.asked = asked;
    }
    if (i >= slots) {
        return;
    }
    if (i >= min(asked, most)) {
        lights[i].radiance = vec3(0.0);
        return;
    }
    uint at = start + i * stride, kind = lights[i].kind;
    uvec3 place = three(at + position), way = three(at + direction), color = three(at + radiance);
    uint size = radius == NOWHERE ? floatBitsToUint(radius_is) : theirs[at + radius];
    uint cone = cos_cone == NOWHERE ? floatBitsToUint(cos_cone_is) : theirs[at + cos_cone];
    bool has_place = kind != LIGHT_DIRECTIONAL, has_way = kind != LIGHT_POINT, has_cone = kind == LIGHT_SPOT;
    // A light of unlimited range has an infinite radius.
    bool ends = size < 0x7F800000u, is_size = size >= floatBitsToUint(LEAST_RADIUS) && size <= 0x7F800000u;
    bool stands = is_not_negative(color.x) && is_not_negative(color.y) && is_not_negative(color.z);
    stands = stands && (!has_place || is_finite(place) && is_size && (ends || kind != LIGHT_VIRTUAL));
    stands = stands && (!has_way || is_unit(way));
    float cosine = uintBitsToFloat(cone);
    stands = stands && (!has_cone || is_positive(cone) && cosine >= WIDEST && cosine < 1.0);
    if (!stands) {
        lights[i].radiance = vec3(0.0);
        atomicAdd(counted.refused, 1u);
        return;
    }
    lights[i].radiance = uintBitsToFloat(color);
    if (has_place) {
        float reach = uintBitsToFloat(size);
        lights[i].position = uintBitsToFloat(place);
        lights[i].falloff = size < floatBitsToUint(MOST_RADIUS) ? 1.0 / (reach * reach) : 0.0;
    }
    if (has_way) {
        lights[i].direction = uintBitsToFloat(way);
    }
    if (has_cone) {
        lights[i].cos_cone = cosine;
    }
}
