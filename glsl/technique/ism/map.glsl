// The map of a virtual light: a paraboloid over the half space into which the light shines, with a distance per texel. Smaller maps of the
// same light, its coarser levels, take points whose discs would be many texels wide in this one. Sources: Brabec, Annen and Seidel 2002
// (dual paraboloid mapping); the levels are ours. Twin: reference::twin::ism::map.
#ifndef TECHNIQUE_ISM_MAP_GLSL
#define TECHNIQUE_ISM_MAP_GLSL
#include "world/light.glsl"

// Texels per side, a power of two.
CONSTANT(uint, ISM_SIZE, 64u)
// Maps of half the size each, down to 4 texels per side.
CONSTANT(uint, ISM_LEVELS, 5u)
// Texels of all levels.
CONSTANT(uint, ISM_TEXELS, 5456u)

// Bits of a texel that nothing was found for: infinity, which is larger than the bits of any distance.
const uint NOTHING = 0x7f800000u;

// The light's axes: `forward` is its normal. Source: Duff et al. 2017.
struct Axes {
    vec3 right;
    vec3 up;
    vec3 forward;
};

Axes axes_of(vec3 forward) {
    precise float side = forward.z >= 0.0 ? 1.0 : -1.0;
    precise float a = -1.0 / (side + forward.z);
    precise float b = forward.x * forward.y * a;
    precise vec3 right = vec3(1.0 + side * forward.x * forward.x * a, side * b, -side * forward.x);
    precise vec3 up = vec3(b, side + forward.y * forward.y * a, -forward.y);
    return Axes(right, up, forward);
}

vec3 into_axes(Axes axes, vec3 v) {
    precise vec3 result = vec3(axes.right.x * v.x + axes.right.y * v.y + axes.right.z * v.z,
                               axes.up.x * v.x + axes.up.y * v.y + axes.up.z * v.z,
                               axes.forward.x * v.x + axes.forward.y * v.y + axes.forward.z * v.z);
    return result;
}

uint level_side(uint level) { return ISM_SIZE >> level; }

// Texels of the levels before: side² · (1 + 1/4 + …).
uint level_start(uint level) {
    uint side = level_side(level);
    return (ISM_SIZE * ISM_SIZE - side * side) / 3u * 4u;
}

uint texel_index(uint level, ivec2 texel) {
    return level_start(level) + uint(texel.y) * level_side(level) + uint(texel.x);
}

// The direction of a place of the map, which goes from -1 to 1 across the half space; its length is 1 + x² + y².
vec3 map_way(vec2 place) {
    precise float square = place.x * place.x + place.y * place.y;
    return vec3(2.0 * place, 1.0 - square);
}

vec2 texel_place(uint level, ivec2 texel) {
    precise vec2 place = (vec2(texel) + 0.5) * (2.0 / float(level_side(level))) - 1.0;
    return place;
}
#endif
