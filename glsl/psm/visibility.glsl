// Particle shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Source: Bavoil and Jansen 2013, Step 4.
//
// Bindings 0 to 2: maps/look_up.glsl, which says how to use this elsewhere. Then
//   binding 3  sampler3D: the volume (psm/constants.glsl), linear, its border 1, or 0 where ADDITIVE
// Specialization constants SLICES, ADDITIVE and LAYERS as the volume was built.
//
// Slice k holds what is left behind all casters of the slices 0 to k, which is so at its far face, the depth
// (k + 1) / SLICES: there it is taken to stand, and in between the values are interpolated. (Taken to stand at the slice's
// middle, as a texture's texels do, everything would come half a slice too early, and a caster would lie in all of its own
// shadow.) So a slice's shadow begins at its near face and is whole at its far face. At the slice's middle, half a slice
// from both, half of it has come: of a sphere's shadow on its own centre that is also the truth. In front of the first
// slice all light is left, behind the last what the last leaves.
#define OWN_FILTER
#include "maps/look_up.glsl"
#include "psm/constants.glsl"

layout(set = GOBO_SET, binding = 3) uniform sampler3D visibility_volume;

// The four slices of a layer about a point given in texels: one bilinear fetch, or the filter's texels one by one.
vec4 layer_slices(View view, Filter f, vec2 at, uint layer) {
    if (FILTER == FILTER_BILINEAR) {
        // At the layer's own depth, so that its neighbours have no weight.
        float z = (float(layer) + 0.5) / float(textureSize(visibility_volume, 0).z);
        return textureLod(visibility_volume, vec3(at / vec2(view.width, view.height), z), 0.0);
    }
    vec4 sum = vec4(0.0);
    for (int i = 0; i < filter_side() * filter_side(); ++i) {
        ivec2 texel = filter_texel(f, i);
        vec4 outside = vec4(ADDITIVE ? 0.0 : 1.0);
        sum += filter_weight(f, i)
             * (view_has(view, texel) ? texelFetch(visibility_volume, ivec3(texel, layer), 0) : outside);
    }
    return sum;
}

float light_visibility(uint light, vec3 position) {
    LookUp l = look_up(light, position);
    if (l.in_front) {
        return l.opaque;
    }
    float place = clamp(l.depth, 0.0, 1.0) * float(SLICES);
    Filter f = filter_at(l.view, l.at);
    // Face i lies behind slice i - 1: face 0 in front of all.
    uint face = min(uint(place), SLICES - 1u);
    uint near = max(face, 1u) - 1u;
    vec4 far_slices = layer_slices(l.view, f, l.at, l.map * LAYERS + face / 4u);
    // Slices k and k + 1 share a layer, save where k is its last.
    vec4 near_slices = near / 4u == face / 4u ? far_slices : layer_slices(l.view, f, l.at, l.map * LAYERS + near / 4u);
    vec2 ends = vec2(near_slices[near % 4u], far_slices[face % 4u]);
    ends = ADDITIVE ? 1.0 - ends : ends;
    ends.x = face == 0u ? 1.0 : ends.x;
    return mix(ends.x, ends.y, place - float(face)) * l.opaque;
}
