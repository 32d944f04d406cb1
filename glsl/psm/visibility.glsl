// Particle shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Source: seed 002 (step 4).
//
// To use it elsewhere: define GOBO_SET (a descriptor set number, default 1) if set 1 is taken, include this file, and bind
//   binding 0  readonly buffer: Light[] (common/light.glsl)
//   binding 1  sampler3D: the volume (psm/constants.glsl), linear, its border 1, or 0 where ADDITIVE is 1
//   binding 2  texture2D: the opaque map of common/opaque_map.glsl (any 1×1 image where has_opaque is 0)
//   binding 3  readonly buffer: Map[] (common/light.glsl)
// with specialization constants 0 (SLICES), 2 (ADDITIVE) and 3 (LAYERS) as the volume was built, and 5 (FILTER) and
// 6 (FILTER_RADIUS) of common/filter.glsl.
//
// Slice k holds what is left behind all casters of the slices 0 to k, which is so at its far face, the depth
// (k + 1) / SLICES: there it is taken to stand, and in between the values are interpolated. (Taken to stand at the slice's
// middle, as a texture's texels do, everything would come half a slice too early, and a caster would lie in all of its own
// shadow.) So a slice's shadow begins at its near face and is whole at its far face. At the slice's middle, half a slice
// from both, half of it has come: of a sphere's shadow on its own centre that is also the truth. In front of the first
// slice all light is left, behind the last what the last leaves.
#define FILTER_CONSTANT 5
#include "common/filter.glsl"
#include "common/opaque_map.glsl"
#include "psm/constants.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1) uniform sampler3D visibility_volume;
layout(set = GOBO_SET, binding = 2) uniform texture2D visibility_opaque;
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityMaps { Map visibility_maps[]; };

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
        vec4 outside = vec4(ADDITIVE == 1u ? 0.0 : 1.0);
        sum += filter_weight(f, i)
             * (view_has(view, texel) ? texelFetch(visibility_volume, ivec3(texel, layer), 0) : outside);
    }
    return sum;
}

float light_visibility(uint light, vec3 position) {
    uint map = light_map(visibility_lights[light], position);
    View view = visibility_maps[map].volume, opaque_view = visibility_maps[map].opaque;
    float opaque = opaque_visibility(visibility_lights[light], opaque_view, map, visibility_opaque, position);
    vec3 at = view_project(view, position);
    if (!(at.z > view.near)) {
        return opaque;  // in front of all casters
    }
    float place = clamp(view_depth(view, at.z), 0.0, 1.0) * float(SLICES);
    Filter f = filter_at(view, at.xy);
    // Face i lies behind slice i - 1: face 0 in front of all.
    uint face = min(uint(place), SLICES - 1u);
    uint near = max(face, 1u) - 1u;
    vec4 far_slices = layer_slices(view, f, at.xy, map * LAYERS + face / 4u);
    // Slices k and k + 1 share a layer, save where k is its last.
    vec4 near_slices = near / 4u == face / 4u ? far_slices : layer_slices(view, f, at.xy, map * LAYERS + near / 4u);
    vec2 ends = vec2(near_slices[near % 4u], far_slices[face % 4u]);
    ends = ADDITIVE == 1u ? 1.0 - ends : ends;
    ends.x = face == 0u ? 1.0 : ends.x;
    return mix(ends.x, ends.y, place - float(face)) * opaque;
}
