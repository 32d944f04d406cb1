// Layers look-up: how much of light `light` reaches `position`, 0 to 1: optical depth grows evenly from the end of one layer to
// that of the next. Sources: Kim and Neumann 2001, Opacity Shadow Maps; Yuksel and Keyser 2008, Deep Opacity Maps.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels as technique/layers/layers.glsl states them, map after map, rows of texels
// Specialization constants PLANES, SUM_RANGE and SUM_STORAGE as the texels were made.
// flat: bindings 96, constants 192: PLANES SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS
#include "technique/layers/layers.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityWords { uint visibility_words[]; };

// From the light to the end of layer k; `at`: of the texel's first.
float layer_optical_depth(uint at, uint k) {
    if (k == 0u) {
        return 0.0;
    }
    if (SUM_STORAGE == STORAGE_F32) {
        return uintBitsToFloat(visibility_words[at + k - 1u]);
    }
    uint word = visibility_words[at + (k - 1u) / 2u];
    vec2 two = SUM_STORAGE == STORAGE_F16 ? unpackHalf2x16(word) : unpackUnorm2x16(word) * DEEPEST;
    return (k & 1u) == 1u ? two.x : two.y;
}

float texel_transmittance(LookUp l, ivec2 texel) {
    uint at = ((l.map * l.view.height + uint(texel.y)) * l.view.width + uint(texel.x)) * texel_words();
    vec2 range = vec2(0.0, 1.0);
    if (SUM_RANGE != RANGE_SCENE) {
        range.x = uintBitsToFloat(visibility_words[at]);
        range.y = SUM_RANGE == RANGE_FRONT ? 1.0 : uintBitsToFloat(visibility_words[at + 1u]);
    }
    at += range_words();
    float place = range_place(range, l.depth);
    uint layer = layer_at(place);
    float begin = layer_end(layer), end = layer_end(layer + 1u);
    float along = clamp((place - begin) / (end - begin), 0.0, 1.0);
    return exp(-mix(layer_optical_depth(at, layer), layer_optical_depth(at, layer + 1u), along));
}
