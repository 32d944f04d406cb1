// Map of a virtual light: a paraboloid projection of the half space that the light shines into, with one distance per texel. Smaller maps
// of the same light, the coarser levels, take points whose discs would be many texels wide in this one. Sources: Brabec, Annen and Seidel
// 2002 (dual paraboloid mapping); the levels are ours. Twin: reference::twin::ism::map.
#ifndef TECHNIQUE_ISM_MAP_GLSL
#define TECHNIQUE_ISM_MAP_GLSL
#include "world/light.glsl"

// Texels per side, a power of two.
CONSTANT(uint, ISM_SIZE, 64u)
// Number of levels, each half the size of the previous one, down to 4 texels per side.
CONSTANT(uint, ISM_LEVELS, 5u)
// Number of texels of all levels.
CONSTANT(uint, ISM_TEXELS, 5456u)

// Bits of an empty texel: infinity, which is larger than the bits of any distance.
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

// Returns the number of texels of all finer levels: side² · (1 + 1/4 + …).
uint level_start(uint level) {
    uint side = level_side(level);
    return (ISM_SIZE * ISM_SIZE - side * side) / 3u * 4u;
}

uint texel_index(uint level, ivec2 texel) {
    return level_start(level) + uint(texel.y) * level_side(level) + uint(texel.x);
}

// Returns the direction of a position in the map, whose coordinates go from -1 to 1 across the half space; its length is 1 + x² + y².
vec3 map_way(vec2 place) {
    precise float square = place.x * place.x + place.y * place.y;
    return vec3(2.0 * place, 1.0 - square);
}

vec2 texel_place(uint level, ivec2 texel) {
    precise vec2 place = (vec2(texel) + 0.5) * (2.0 / float(level_side(level))) - 1.0;
    return place;
}
#endif
