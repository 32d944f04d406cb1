// Finishes a map after all points have been splatted: copies wide points down to the finest level, and fills holes between points by
// pull-push within the map. The threads of a workgroup cooperate; they access texels through three functions of the including shader:
// texel_get, texel_set and texel_barrier. Sources: Ritschel et al. 2008, section 4.3 (pull-push), limited here by the size of points, so
// that real gaps stay empty. Twin: reference::twin::ism::fill.
#ifndef TECHNIQUE_ISM_FILL_GLSL
#define TECHNIQUE_ISM_FILL_GLSL
#include "technique/ism/map.glsl"

// Maximum width of a hole that is filled, in radii of a point.
const float WIDE = 8.0;

// Returns the distance to the nearest point in a texel; NOTHING counts as infinity.
float level_get(uint level, ivec2 texel) { return uintBitsToFloat(texel_get(texel_index(level, texel))); }

void level_set(uint level, ivec2 texel, float distance) {
    texel_set(texel_index(level, texel), floatBitsToUint(distance));
}

// Returns the width of a texel of the level at a distance of 1, in world units.
float texel_wide(uint level, ivec2 texel) {
    vec2 place = texel_place(level, texel);
    precise float wide = 4.0 / ((1.0 + (place.x * place.x + place.y * place.y)) * float(level_side(level)));
    return wide;
}

void wide_down(uint thread, uint threads) {
    for (uint level = ISM_LEVELS - 1u; level-- > 0u;) {
        uint side = level_side(level);
        for (uint i = thread; i < side * side; i += threads) {
            ivec2 texel = ivec2(i % side, i / side);
            level_set(level, texel, min(level_get(level, texel), level_get(level + 1u, texel / 2)));
        }
        texel_barrier();
    }
}

// A texel is a hole only if its neighbours that have a distance add up to at least this weight, more than three quarters of the weight of
// all neighbours, 16. A hole has points on all sides; a texel beside a straight edge is not a hole.
const float SURROUNDED = 13.0;

// Returns the weighted mean of four distances, without any that belong to a different surface than the nearest one; NOTHING if the
// remaining weights add up to less than `least`. A distance belongs to that surface if it exceeds the nearest by at most twice the sum of a
// point's radius and a texel's width, as on a surface that the light sees at a slant. `wide`: texel_wide.
float mean_of(vec4 distances, vec4 weights, float least, float wide, float radius) {
    float nearest = min(min(distances.x, distances.y), min(distances.z, distances.w));
    precise float last = nearest + 2.0 * (radius + wide * nearest);
    precise float sum = 0.0, weight = 0.0;
    for (uint i = 0u; i < 4u; ++i) {
        if (distances[i] <= last && distances[i] <= FARTHEST) {
            sum += weights[i] * distances[i];
            weight += weights[i];
        }
    }
    // Rounding must not make the mean nearer than the nearest distance.
    return weight >= least ? max(sum / weight, nearest) : uintBitsToFloat(NOTHING);
}

void pull(uint thread, uint threads, float radius) {
    for (uint level = 1u; level < ISM_LEVELS; ++level) {
        uint side = level_side(level);
        for (uint i = thread; i < side * side; i += threads) {
            ivec2 texel = ivec2(i % side, i / side), first = 2 * texel;
            vec4 four = vec4(level_get(level - 1u, first), level_get(level - 1u, first + ivec2(1, 0)),
                             level_get(level - 1u, first + ivec2(0, 1)), level_get(level - 1u, first + 1));
            float wide = texel_wide(level, texel), mean = mean_of(four, vec4(1.0), 1.0, wide, radius);
            // No mean if a texel at that distance is wider than a hole may be.
            precise float apart = WIDE * radius, across = mean * wide;
            level_set(level, texel, across <= apart ? mean : uintBitsToFloat(NOTHING));
        }
        texel_barrier();
    }
}

void push(uint thread, uint threads, float radius) {
    for (uint level = ISM_LEVELS - 1u; level-- > 0u;) {
        uint side = level_side(level);
        ivec2 last = ivec2(level_side(level + 1u) - 1u);
        for (uint i = thread; i < side * side; i += threads) {
            ivec2 texel = ivec2(i % side, i / side);
            if (level_get(level, texel) <= FARTHEST) {
                continue;
            }
            // The four coarser texels around it, the one that contains it first.
            ivec2 about = texel / 2, beside = clamp(about + 2 * (texel & 1) - 1, ivec2(0), last);
            vec4 four = vec4(level_get(level + 1u, about), level_get(level + 1u, ivec2(beside.x, about.y)),
                             level_get(level + 1u, ivec2(about.x, beside.y)), level_get(level + 1u, beside));
            level_set(level, texel, mean_of(four, vec4(9.0, 3.0, 3.0, 1.0), SURROUNDED, texel_wide(level, texel), radius));
        }
        texel_barrier();
    }
}
#endif
