// A light and the two views that its maps are drawn with. Twin: technique::LightData.
#ifndef COMMON_LIGHT_GLSL
#define COMMON_LIGHT_GLSL
#include "common/view.glsl"

struct Light {
    View volume;      // of the translucent casters: fitted to them
    View opaque;      // of the meshes and all that they may shadow
    vec3 radiance;
    uint has_opaque;  // 0: nothing opaque casts, and the opaque map is a dummy
    float cos_cone;   // cosine of half the cone of a spot light; -2 for a directional one
};

// Direction from a point towards the light, unit length.
vec3 light_direction(Light light, vec3 position) {
    return light.volume.projection == VIEW_PARALLEL ? -light.volume.forward
                                                    : normalize(light.volume.origin - position);
}

// What the light sends towards a point if nothing stands between.
vec3 light_radiance(Light light, vec3 position) {
    float cosine = dot(-light_direction(light, position), light.volume.forward);
    return cosine >= light.cos_cone ? light.radiance : vec3(0.0);
}
#endif
