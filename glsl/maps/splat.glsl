// What draws of casters are pushed, one draw a map. Maps stand one above the other in what is drawn to.
// Twin: maps::splat::SplatPush.
#ifndef MAPS_SPLAT_GLSL
#define MAPS_SPLAT_GLSL

layout(push_constant, scalar) uniform SplatPush {
    uint map;
    uint order_first;
    uint slot;   // of the map among those that are drawn at once
    uint group;  // which of the groups of maps that are drawn at once
    uint capacity;  // of the lists that are drawn into, if any
};

#ifdef SPLAT_FRAGMENT
layout(location = 0) flat in uint caster_index;

// Of the map.
uvec2 splat_texel(View view) { return uvec2(gl_FragCoord.xy) - uvec2(0u, slot * view.height); }
#endif
#endif
