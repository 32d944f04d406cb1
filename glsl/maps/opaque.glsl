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
ivec2 opaque_corner(View view, uint map, sampler2D depth_map) {
    uint rows = max(uint(textureSize(depth_map, 0).y) / view.height, 1u);
    return ivec2(map / rows * view.width, map % rows * view.height);
}

// The depths of four texels of the map that stands at `corner`, from `texel` on, rows first, in one fetch; of those outside the
// map what is in others.
vec4 opaque_quad(ivec2 corner, sampler2D depth_map, ivec2 texel) {
    // Where the four meet: as far from any other four as a place can be.
    vec2 middle = vec2(corner + texel + 1);
    return textureGather(depth_map, middle / vec2(textureSize(depth_map, 0))).wzxy;
}

// The same with 1, nothing, outside the map.
vec4 opaque_quad_inside(View view, ivec2 corner, sampler2D depth_map, ivec2 texel) {
    vec4 hits = opaque_quad(corner, depth_map, texel);
    ivec2 size = ivec2(view.width, view.height);
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel + 1, size))) {
        for (int i = 0; i < 4; ++i) {
            hits[i] = view_has(view, texel + ivec2(i & 1, i >> 1)) ? hits[i] : 1.0;
        }
    }
    return hits;
}

// Which depths end the light in front of one: those that are less than it, and not 1, where there is nothing.
bvec4 opaque_ends(vec4 hits, float depth) { return lessThan(hits, vec4(min(depth, 1.0))); }

// Through map `map` of the light, whose opaque view is `view`.
float opaque_visibility(Light light, View view, uint map, sampler2D depth_map, vec3 position) {
    if (light.has_opaque == 0u) {
        return 1.0;
    }
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return 1.0;
    }
    Footprint footprint = view_footprint(view, at.xy);
    ivec2 corner = opaque_corner(view, map, depth_map);
    vec4 hits = opaque_quad_inside(view, corner, depth_map, footprint.corner);
    bvec4 ends = opaque_ends(hits, view_depth(view, at.z));
    float visible = 0.0;
    for (int i = 0; i < 4; ++i) {
        visible += ends[i] ? 0.0 : footprint.weights[i];
    }
    return visible;
}
#endif
