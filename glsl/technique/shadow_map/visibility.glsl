// Shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Sources: Williams 1978; Reeves, Salesin and Cook 1987
// (percentage closer filtering). Twin: reference::twin::shadow_map. The look-up compares a square of PCF × PCF texels around the point's
// ray, each texel individually and all with the same weight. For a point on a surface, a texel is compared with the depth of the surface's
// plane at that texel. A wide filter fetches four texels at once.
//
// Bindings 0 to 2: maps/look_up_set.glsl. Set the specialization constant PCF to the value that the map was built for.
// flat: bindings 40, constants 80: PCF GATHERS NORMAL_BIAS CASCADES CASCADE_MAPS
#include "maps/look_up_set.glsl"
#include "maps/opaque.glsl"

// Side of the square that is compared, in texels.
CONSTANT(uint, PCF, 1u)

// Whether texels are gathered, four per fetch, instead of fetched one by one.
CONSTANT(bool, GATHERS, true)

// Maps per light, each half as wide as the previous one.
CONSTANT(uint, CASCADES, 1u)

// Number of maps of all lights in one cascade; the list has as many for each further cascade.
CONSTANT(uint, CASCADE_MAPS, 1u)

// Returns the narrowest map of a light that contains the point and `texels` texels around it, else the widest.
uint map_about(Light light, vec3 position, float texels) {
    uint map = light_map(light, position);
    for (uint cascade = CASCADES - 1u; cascade > 0u; --cascade) {
        View view = look_up_maps[map + cascade * CASCADE_MAPS].opaque;
        vec2 at = view_project(view, position).xy;
        if (all(greaterThan(at, vec2(texels))) && all(lessThan(at, vec2(view.width, view.height) - texels))) {
            return map + cascade * CASCADE_MAPS;
        }
    }
    return map;
}

#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    Light l = look_up_lights[light];
    look_up_normal = normal;
    if (l.has_opaque == 0u) {
        return position;
    }
    // One texel more margin than in the look-up itself: if the moved point then falls into another map, that map is finer.
    return opaque_receiver(look_up_maps[map_about(l, position, 0.5 * float(PCF) + 2.0)].opaque, position, normal);
}

float light_visibility(uint light, vec3 position) {
    vec3 normal = look_up_normal;
    look_up_normal = vec3(0.0);
    Light l = look_up_lights[light];
    if (l.has_opaque == 0u) {
        return 1.0;
    }
    uint map = map_about(l, position, 0.5 * float(PCF) + 1.0);
    View view = look_up_maps[map].opaque;
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return 1.0;
    }
    Receiver receiver = opaque_compared(view, position, at.z, normal);
    if (opaque_is_turned(receiver)) {
        return 0.0;
    }
    ivec2 corner = opaque_corner(view, map, look_up_opaque);
    int side = int(PCF);
    // Clamped so that the conversion to integers is defined: far outside, all texels are outside.
    vec2 inside = clamp(at.xy, vec2(-float(side)), vec2(view.width, view.height) + float(side));
    // Outside the map nothing blocks the light.
    ivec2 first = ivec2(floor(inside)) - side / 2;
    ivec2 low = max(first, ivec2(0)), high = min(first + side, ivec2(view.width, view.height));
    int stride = GATHERS ? 2 : 1;
    uint dark = 0u;
    for (int y = low.y; y < high.y; y += stride) {
        for (int x = low.x; x < high.x; x += stride) {
            vec2 apart = vec2(x, y) + 0.5 - at.xy;
            if (GATHERS) {
                vec4 hits = opaque_quad(corner, look_up_opaque, ivec2(x, y));
                uvec4 ends = uvec4(opaque_quad_ends(view, receiver, hits, apart));
                // If the side is odd, the last gather of a row or column includes texels beyond the square, which do not count.
                uvec2 rows = ends.xz + (x + 1 < high.x ? ends.yw : uvec2(0u));
                dark += rows.x + (y + 1 < high.y ? rows.y : 0u);
            } else {
                float hit = texelFetch(look_up_opaque, corner + ivec2(x, y), 0).r;
                dark += uint(opaque_ends(view, receiver, hit, apart));
            }
        }
    }
    // Exact if none or all are dark, even if a device divides by multiplying.
    return dark == 0u ? 1.0 : float(uint(side * side) - dark) / float(side * side);
}
