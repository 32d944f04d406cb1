// Shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Sources: Williams 1978; Reeves, Salesin and
// Cook 1987 (percentage closer filtering). Twin: reference::twin::shadow_map.
// The texel that the point's ray goes through and those about it, PCF a side: each is compared by itself, and all count
// the same. A wide filter fetches four at once.
//
// Bindings 0 to 2: maps/look_up_set.glsl. The specialization constant PCF is what the map was made for.
// flat: bindings 40, constants 80: PCF GATHERS
#include "maps/look_up_set.glsl"
#include "maps/opaque.glsl"

// Texels a side that are compared.
CONSTANT(uint, PCF, 1u)

// Whether texels are gathered, four in a fetch, and not fetched one by one.
CONSTANT(bool, GATHERS, true)

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
    // Outside the map nothing ends the light.
    ivec2 first = ivec2(floor(inside)) - side / 2;
    ivec2 low = max(first, ivec2(0)), high = min(first + side, ivec2(view.width, view.height));
    int stride = GATHERS ? 2 : 1;
    uint dark = 0u;
    for (int y = low.y; y < high.y; y += stride) {
        for (int x = low.x; x < high.x; x += stride) {
            if (GATHERS) {
                uvec4 ends = uvec4(opaque_ends(opaque_quad(corner, look_up_opaque, ivec2(x, y)), depth));
                // The last of an odd number in a row or column comes with one that does not count.
                uvec2 rows = ends.xz + (x + 1 < high.x ? ends.yw : uvec2(0u));
                dark += rows.x + (y + 1 < high.y ? rows.y : 0u);
            } else {
                dark += uint(texelFetch(look_up_opaque, corner + ivec2(x, y), 0).r < min(depth, 1.0));
            }
        }
    }
    // A device may divide by multiplying: none and all are exact.
    return dark == 0u ? 1.0 : float(uint(side * side) - dark) / float(side * side);
}
