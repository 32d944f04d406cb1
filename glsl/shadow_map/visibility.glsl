// Shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Sources: Williams 1978; Reeves, Salesin and
// Cook 1987 (percentage closer filtering). Twin: reference::twin::shadow_map.
// The texel that the point's ray goes through and those about it, PCF a side: each is compared by itself, and all count
// the same.
//
// To use this elsewhere: define GOBO_SET (a descriptor set number, default 1) if set 1 is taken, bind what
// maps/look_up_set.glsl says, and set the specialization constant PCF as the map was made for.
#include "maps/look_up_set.glsl"
#include "maps/opaque.glsl"

CONSTANT(uint, PCF, 1u)

float light_visibility(uint light, vec3 position) {
    Light l = look_up_lights[light];
    if (l.has_opaque == 0u) {
        return 1.0;
    }
    uint map = light_map(l, position);
    View view = look_up_maps[map].opaque;
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return 1.0;
    }
    float depth = view_depth(view, at.z);
    ivec2 corner = opaque_corner(view, map, look_up_opaque);
    int side = int(PCF);
    // Far outside, all texels are outside: clamped so that the conversion to integers is defined.
    vec2 inside = clamp(at.xy, vec2(-float(side)), vec2(view.width, view.height) + float(side));
    ivec2 first = ivec2(floor(inside)) - side / 2;
    uint lit = 0u;
    for (int i = 0; i < side * side; ++i) {
        ivec2 texel = first + ivec2(i % side, i / side);
        lit += uint(opaque_leaves(view, corner, look_up_opaque, texel, depth));
    }
    // A device may divide by multiplying: none and all are exact.
    return lit == uint(side * side) ? 1.0 : float(lit) / float(side * side);
}
