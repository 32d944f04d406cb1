// Visibility past the meshes: a plain depth map, compared at four texels and weighted bilinearly. The map holds depths in the light's
// range, 1 where there is no mesh (maps/opaque.frag). A look-up keeps a surface out of its own shadow: a texel darkens a point of a surface
// only under two conditions. The texel's depth is nearer than the point's, and the position at the texel's depth is above the surface's
// plane. Both are tested for the point after NORMAL_BIAS has moved it off the surface, and for the plane through the moved point. A point
// in space has no plane. One texture holds all maps: see opaque_corner. Twin: reference::twin::receiver.
#ifndef MAPS_OPAQUE_GLSL
#define MAPS_OPAQUE_GLSL
#extension GL_EXT_samplerless_texture_functions : require
#include "world/light.glsl"

// Upper left texel of a map in the image of all maps. Maps are stacked vertically; if an image cannot have so many rows, they continue in
// further columns. Twin: maps::opaque_corner.
ivec2 opaque_corner(View view, uint map, sampler2D depth_map) {
    uint rows = max(uint(textureSize(depth_map, 0).y) / view.height, 1u);
    return ivec2(map / rows * view.width, map % rows * view.height);
}

// Depths of four texels of the map at `corner`, from `texel` on, row by row, in one fetch. Texels outside the map belong to other maps.
vec4 opaque_quad(ivec2 corner, sampler2D depth_map, ivec2 texel) {
    // The corner that the four texels share: a gather at this position returns exactly these four.
    vec2 middle = vec2(corner + texel + 1);
    return textureGather(depth_map, middle / vec2(textureSize(depth_map, 0))).wzxy;
}

// Like opaque_quad, but with 1 (no mesh) outside the map.
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

// How far a point of a surface is moved along the surface's normal, as a fraction of a texel's extent along that normal. This exceeds the
// distance by which vertex snapping and rounding can displace the surface.
CONSTANT(float, NORMAL_BIAS, 0.3)

// Normal of the surface at the next point, on the side whose light is queried; 0 for a point in space. light_receiver sets it,
// light_visibility resets it to 0.
vec3 look_up_normal = vec3(0.0);

// The receiver with which texels around a point are compared.
struct Receiver {
    float point_z;
    float depth;     // at most 1, which means no mesh
    float along;     // change in height above the surface's plane per unit of z along the point's ray,
    vec2 across;     // and per texel to the right and up, in perspective at z = 1
    float least;     // the height above the plane from which a texel shadows the point
};

vec3 opaque_texel_right(View view) { return view.right * (2.0 / (float(view.width) * view.scale_x)); }

vec3 opaque_texel_up(View view) { return view.up * (2.0 / (float(view.height) * view.scale_y)); }

// Position at which a point of a surface is looked up, moved off the surface.
vec3 opaque_receiver(View view, vec3 position, vec3 normal) {
    vec3 offset = position - view.origin, coordinates = abs(position);
    float z = view.projection == VIEW_PARALLEL ? 1.0 : dot(offset, view.forward);
    float texels = abs(dot(normal, opaque_texel_right(view))) + abs(dot(normal, opaque_texel_up(view)));
    // Twice the rounding error bound of maps/stored.glsl.
    float rounding = 2.4e-7 * (coordinates.x + coordinates.y + coordinates.z) + 1.2e-6 * length(offset);
    float by = NORMAL_BIAS * texels * z;
    // The point never passes the light: it moves by at most half the light's height above the surface.
    by = view.projection == VIEW_PARALLEL ? by : min(by, -0.5 * dot(offset, normal));
    return position + normal * max(by, rounding);
}

// The receiver for a point that the view sees at `z`; `normal`: the normal of the point's surface, or 0.
Receiver opaque_compared(View view, vec3 position, float z, vec3 normal) {
    Receiver receiver;
    receiver.point_z = z;
    receiver.depth = min(view_depth(view, z), 1.0);
    vec3 direction = view.projection == VIEW_PARALLEL ? view.forward : (position - view.origin) / z;
    receiver.along = dot(normal, direction);
    receiver.across = vec2(dot(normal, opaque_texel_right(view)), dot(normal, opaque_texel_up(view)));
    receiver.least = dot(normal, normal) > 0.0 ? 0.0 : -1.0;
    return receiver;
}

// Whether the surface faces away from the light, and so shadows itself.
bool opaque_is_turned(Receiver receiver) { return receiver.least == 0.0 && receiver.along >= 0.0; }

// Whether a texel blocks the point's light; `apart`: offset from the point to the texel's centre, in texels. A flat surface never blocks
// its own light.
bool opaque_ends(View view, Receiver receiver, float hit, vec2 apart) {
    float z = view.near + hit * (view.far - view.near);
    float above = (z - receiver.point_z) * receiver.along +
                  dot(apart, receiver.across) * (view.projection == VIEW_PARALLEL ? 1.0 : z);
    return hit < receiver.depth && above > receiver.least;
}

// The same test for four texels; `apart`: offset to the first.
bvec4 opaque_quad_ends(View view, Receiver receiver, vec4 hits, vec2 apart) {
    return bvec4(opaque_ends(view, receiver, hits.x, apart), opaque_ends(view, receiver, hits.y, apart + vec2(1.0, 0.0)),
                 opaque_ends(view, receiver, hits.z, apart + vec2(0.0, 1.0)),
                 opaque_ends(view, receiver, hits.w, apart + 1.0));
}

// Visibility past the meshes in map `map` of the light, whose opaque view is `view`. `normal`: the normal of the surface that contains the
// point, or 0.
float opaque_visibility(Light light, View view, uint map, sampler2D depth_map, vec3 position, vec3 normal) {
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
    Receiver receiver = opaque_compared(view, position, at.z, normal);
    if (opaque_is_turned(receiver)) {
        return 0.0;
    }
    bvec4 ends = opaque_quad_ends(view, receiver, hits, vec2(footprint.corner) + 0.5 - at.xy);
    float visible = 0.0;
    for (int i = 0; i < 4; ++i) {
        visible += ends[i] ? 0.0 : footprint.weights[i];
    }
    return visible;
}
#endif
