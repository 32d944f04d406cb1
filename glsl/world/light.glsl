// A light, and the maps through which it is looked up. A directional or a spot light has one map; a point or a virtual light has six, the
// faces of a cube. Twins: world::LightData, maps::Map, scene::Light.
#ifndef WORLD_LIGHT_GLSL
#define WORLD_LIGHT_GLSL
#include "world/face.glsl"
#include "world/view.glsl"

const uint LIGHT_DIRECTIONAL = 0u;
const uint LIGHT_SPOT = 1u;
const uint LIGHT_POINT = 2u;
const uint LIGHT_VIRTUAL = 3u;

struct Light {
    vec3 position;    // 0 for a directional light
    uint kind;        // LIGHT_DIRECTIONAL, LIGHT_SPOT, LIGHT_POINT or LIGHT_VIRTUAL
    vec3 direction;   // travel direction of a directional light, axis of a spot light, normal of a virtual one; 0 for a point light
    float cos_cone;   // cosine of half a spot light's cone angle; 0 for a virtual light, -2 for directional and point lights
    vec3 radiance;
    float falloff;    // 1 / radius² of a spot or a point light of limited range, else 0; 1 / nearest² of a virtual light
    uint first_map;
    uint map_count;   // 6 for a point or a virtual light, else 1
    uint has_opaque;  // 0: no opaque casters, and the opaque map is a dummy
};

struct Map {
    View caster_view;  // fitted to the translucent casters
    View opaque;  // covers the meshes and everything that they may shadow
};

// Unit vector from a point towards the light.
vec3 light_direction(Light light, vec3 position) {
    return light.kind == LIGHT_DIRECTIONAL ? -light.direction : normalize(light.position - position);
}

// Attenuation of the light at a point: 1 at the light, falling smoothly to 0 at its radius. A virtual light is attenuated by distance and
// cosine.
float light_falloff(Light light, vec3 position) {
    vec3 offset = position - light.position;
    if (light.kind == LIGHT_VIRTUAL) {
        float squared = dot(offset, offset);
        float cosine = squared > 0.0 ? dot(offset, light.direction) * inversesqrt(squared) : 0.0;
        return max(cosine, 0.0) * min(1.0 / squared, light.falloff);
    }
    float left = light.falloff > 0.0 ? max(0.0, 1.0 - dot(offset, offset) * light.falloff) : 1.0;
    return left * left;
}

// Radiance from the light towards a point, without any occlusion.
vec3 light_radiance(Light light, vec3 position) {
    float cosine = dot(-light_direction(light, position), light.direction);
    return cosine >= light.cos_cone ? light.radiance * light_falloff(light, position) : vec3(0.0);
}

// The map in which to look up a point: for a point or a virtual light, the face in the point's direction.
uint light_map(Light light, vec3 position) {
    return light.first_map + (light.map_count == 1u ? 0u : cube_face(position - light.position));
}
#endif
