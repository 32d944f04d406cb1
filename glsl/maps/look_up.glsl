// The look-up of every technique with maps: selects the map, computes the visibility past the meshes, and averages texels. Bindings 0 to 2
// are those of maps/look_up_set.glsl; bindings from 3 on belong to the technique. A point light's faces have a margin around their 90
// degrees that is wide enough for every filter, so that no look-up needs two faces. Bound by maps::Maps::look_up.
#ifndef MAPS_LOOK_UP_GLSL
#define MAPS_LOOK_UP_GLSL
#include "maps/filter.glsl"
#include "maps/look_up_set.glsl"
#include "maps/opaque_look_up.glsl"
#include "world/colors.glsl"

// A point's position in the map that is looked up.
struct LookUp {
    uint map;
    View view;
    vec2 at;         // texels
    float depth;     // in the light's range
    bool in_front;   // in front of all casters, so that none blocks light
    float opaque;    // visibility past the meshes
    uint first;      // number of texels before those of the level of detail that is looked up
};

LookUp look_up(uint light, vec3 position, vec3 normal) {
    LookUp l;
    l.map = light_map(look_up_lights[light], position);
    l.view = look_up_maps[l.map].caster_view;
    l.opaque = opaque_leaves(light, l.map, position, normal);
    vec3 at = view_project(l.view, position);
    l.at = at.xy;
    l.in_front = !(at.z > l.view.near);
    l.depth = view_depth(l.view, at.z);
    l.first = 0u;
    return l;
}

// Position of a map's texel in an image in which the maps are stacked vertically.
ivec2 stacked(LookUp l, ivec2 texel) { return texel + ivec2(0, l.map * l.view.height); }

// Transmittance along the ray of one texel, up to the look-up's depth; defined by each technique with texels.
float texel_transmittance(LookUp l, ivec2 texel);

// The mean over the filter's texels.
float filtered_transmittance(LookUp l) {
    Filter f = filter_at(l.view, l.at);
    float transmittance = 0.0;
    for (int i = 0; i < filter_side() * filter_side(); ++i) {
        ivec2 texel = filter_texel(f, i);
        // The map is fitted to the casters: past its edge none blocks light.
        transmittance += filter_weight(f, i) * (view_has(l.view, texel) ? texel_transmittance(l, texel) : 1.0);
    }
    return transmittance;
}

#ifndef MAP_TRANSMITTANCE
#define MAP_TRANSMITTANCE filtered_transmittance
#else
// Defined by a technique that does not use filtered_transmittance alone.
float MAP_TRANSMITTANCE(LookUp l);
#endif

float light_visibility(uint light, vec3 position) {
    LookUp l = look_up(light, position, look_up_normal);
    look_up_normal = vec3(0.0);
    look_up_meshes = l.opaque;
    return l.in_front ? l.opaque : MAP_TRANSMITTANCE(l) * l.opaque;
}
#endif
