// Push constants of draws of casters, one draw per map. The target holds the maps, stacked vertically. Twin:
// maps::caster_quads::QuadsPush.
#ifndef MAPS_SPLAT_GLSL
#define MAPS_SPLAT_GLSL
#include "maps/bins/view_caster.glsl"
#include "maps/scene.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/sheet.glsl"

layout(push_constant, scalar) uniform QuadsPush {
    uint map;
    uint order_first;
    uint slot;   // index of the map within the group that is drawn at once
    uint group;  // index of the group of maps that are drawn at once
    uint capacity;  // capacity of the lists that fragments are appended to, if any
};

#ifdef QUADS_FRAGMENT
// A caster in the view's axes: its position and radius, then its axis and density.
layout(location = 0) flat in vec4 ball;
layout(location = 1) flat in vec4 rest;

// The fragment's texel in the map.
uvec2 quad_texel(View view) { return uvec2(gl_FragCoord.xy) - uvec2(0u, slot * view.height); }

// The segment of the caster in the texel, cut off at an optical depth of `dark`, as depths in the light's range. False if there is none.
bool quad_part(View view, float dark, out vec2 depth, out float optical_depth) {
    Caster caster = Caster(ball.xyz, ball.w, STRANDS || SPLATS_OR_CELLS || SHEETS ? rest.xyz : vec3(0.0), rest.w);
    Ray ray = view_texel_ray(view, quad_texel(view));
    vec2 z;
    bool hit = view_segment(view, ray, length(ray.direction), caster, dark, z, optical_depth);
    depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
    return hit;
}

bool quad_segment(View view, out vec2 depth, out float optical_depth) {
    return quad_part(view, MAX_OPTICAL_DEPTH, depth, optical_depth);
}
#endif
#endif
