// Look-ups through levels of detail: each texel of a level holds the mean transmittance of the four below it, and a look-up reads the
// levels whose texels are about as wide as its footprint. A technique includes this file before maps/look_up.glsl, stores its texels at
// texel_place, and defines MAP_TRANSMITTANCE as leveled_transmittance or calls it. Invariant: with LEVELS 1, or with a look_up_footprint of
// 0, the result equals filtered_transmittance.
#ifndef MAPS_LEVELS_GLSL
#define MAPS_LEVELS_GLSL
#define TECHNIQUE_FOOTPRINTS
#include "maps/level_place.glsl"
#include "maps/look_up.glsl"

// Width of the area that receives light, such as a pixel, perpendicular to the light, world units; 0: a point.
float look_up_footprint = 0.0;

// Offset of the level: a look-up averages several texels around a position and so covers a wider area than one texel does. Half a level
// finer makes up for that.
const float LEVEL_BIAS = -0.5;

// Index of a texel of the look-up among those of all maps and levels.
uint texel_place(LookUp l, ivec2 texel) {
    return l.first + (l.map * l.view.height + uint(texel.y)) * l.view.width + uint(texel.x);
}

// Index of the same texel among the texels of levels 1 and up.
uint coarser_place(LookUp l, ivec2 texel) {
    return texel_place(l, texel) - look_up_maps[0].caster_view.width * look_up_maps[0].caster_view.height * look_up_maps.length();
}

// The level whose texels are as wide as the footprint at the point.
float footprint_level(LookUp l) {
    float spread = l.view.projection == VIEW_PARALLEL ? 1.0 : mix(l.view.near, l.view.far, max(l.depth, 0.0));
    vec2 sides = abs(2.0 * spread / (vec2(l.view.width, l.view.height) * vec2(l.view.scale_x, l.view.scale_y)));
    float level = log2(look_up_footprint * inversesqrt(sides.x * sides.y)) + LEVEL_BIAS;
    return clamp(level, 0.0, float(LEVELS - 1u));
}

// Converts a look-up to a level of detail.
LookUp in_level(LookUp l, uint level) {
    uvec2 size = uvec2(l.view.width, l.view.height), its = level_size(size, level);
    bool inside = all(greaterThanEqual(l.at, vec2(0.0))) && all(lessThanEqual(l.at, vec2(size)));
    l.first = level_first(size, look_up_maps.length(), level);
    l.at *= exp2(-float(level));
    if (level > 0u && inside && l.view.projection == VIEW_PERSPECTIVE) {
        // Casters continue past the edge of a cube's face, but the face's margin is too narrow for the wider texels of this level.
        l.at = clamp(l.at, vec2(0.5), vec2(its) - 0.5);
    }
    l.view.width = its.x;
    l.view.height = its.y;
    return l;
}

// Interpolates linearly between two levels.
float leveled_transmittance(LookUp l) {
    if (LEVELS == 1u || !(look_up_footprint > 0.0)) {
        return filtered_transmittance(l);
    }
    float level = footprint_level(l), share = fract(level), transmittance = 0.0;
    for (uint i = 0u; i < 2u; ++i) {
        float weight = i == 0u ? 1.0 - share : share;
        if (weight > 0.0) {
            transmittance += weight * filtered_transmittance(in_level(l, uint(level) + i));
        }
    }
    return transmittance;
}
#endif
