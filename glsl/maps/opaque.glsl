// Visibility past the meshes: a plain depth map, compared at four texels and weighted bilinearly.
// The map holds depths in the light's range (1 where there is nothing), pushed away by what the surface's depth changes over
// the look-up's reach (maps/opaque.frag), here one texel: a compare is up to one texel from a texel's centre, so a plane
// never shadows itself.
// All maps stand in one texture: see opaque_corner.
#ifndef MAPS_OPAQUE_GLSL
#define MAPS_OPAQUE_GLSL
#extension GL_EXT_samplerless_texture_functions : require
#include "world/light.glsl"

// The upper left texel of a map among all: one above the other, and where that is more rows than an image has, in
// further columns. Twin: maps::opaque_corner.
ivec2 opaque_corner(View view, uint map, texture2D depth_map) {
    uint rows = max(uint(textureSize(depth_map, 0).y) / view.height, 1u);
    return ivec2(map / rows * view.width, map % rows * view.height);
}

// Whether one texel of the map that stands at `corner` leaves the light at a depth: there is nothing, or nothing in front.
bool opaque_leaves(View view, ivec2 corner, texture2D depth_map, ivec2 texel, float depth) {
    float hit = view_has(view, texel) ? texelFetch(depth_map, corner + texel, 0).r : 1.0;
    return hit >= 1.0 || depth <= hit;
}

// Through map `map` of the light, whose opaque view is `view`.
float opaque_visibility(Light light, View view, uint map, texture2D depth_map, vec3 position) {
    if (light.has_opaque == 0u) {
        return 1.0;
    }
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return 1.0;
    }
    float depth = view_depth(view, at.z);
    Footprint footprint = view_footprint(view, at.xy);
    ivec2 corner = opaque_corner(view, map, depth_map);
    float visible = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = footprint.corner + ivec2(i & 1, i >> 1);
        visible += opaque_leaves(view, corner, depth_map, texel, depth) ? footprint.weights[i] : 0.0;
    }
    return visible;
}
#endif
