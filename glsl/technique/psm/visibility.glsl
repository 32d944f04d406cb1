// Particle shadow map look-up: how much of light `light` reaches `position`, 0 to 1. Source: Bavoil and Jansen 2013, Step 4.
//
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  the volume (technique/psm/constants.glsl), R8G8B8A8_UNORM or R16G16B16A16_SFLOAT, linear, with a border of 1, or 0 if
//              ADDITIVE
// Set the specialization constants SLICES, ADDITIVE and LAYERS to the values that the volume was built with.
// flat: bindings 24, constants 48: SLICES LAYERS ADDITIVE FILTER FILTER_RADIUS
//
// Slice k holds the light left behind all casters of the slices 0 to k. That is the light at its far face, at the depth (k + 1) / SLICES,
// so the value is placed there, and values between faces are interpolated. (If it were placed at the slice's midpoint, like a texture's
// texels, every shadow would begin half a slice too early, and a caster would be in all of its own shadow.) A slice's shadow therefore
// begins at its near face and is complete at its far face. At the slice's midpoint it is half complete, as is the true shadow of a sphere
// at its own centre. In front of the first slice all light is left; behind the last, the light that the last slice leaves.
#define MAP_TRANSMITTANCE slices_transmittance
#include "maps/look_up.glsl"
#include "technique/psm/constants.glsl"

layout(set = GOBO_SET, binding = 3) uniform sampler3D visibility_volume;

// The faces around a depth: face i lies behind slice i - 1, face 0 in front of all slices.
struct Faces {
    uint face;    // face at or in front of the depth
    uint near;    // slice in front of that face, if there is one
    float share;  // share of the distance to the next face
};

Faces depth_faces(float depth) {
    float place = clamp(depth, 0.0, 1.0) * float(SLICES);
    uint face = min(uint(place), SLICES - 1u);
    return Faces(face, max(face, 1u) - 1u, place - float(face));
}

// Interpolates between the values of slice `near` and of slice `face`.
float between(Faces f, vec4 near_slices, vec4 far_slices) {
    vec2 ends = vec2(near_slices[f.near % 4u], far_slices[f.face % 4u]);
    ends = ADDITIVE ? 1.0 - ends : ends;
    ends.x = f.face == 0u ? 1.0 : ends.x;
    return mix(ends.x, ends.y, f.share);
}

float texel_transmittance(LookUp l, ivec2 texel) {
    Faces f = depth_faces(l.depth);
    ivec3 at = ivec3(texel, l.map * LAYERS);
    vec4 far_slices = texelFetch(visibility_volume, at + ivec3(0, 0, f.face / 4u), 0);
    return between(f, texelFetch(visibility_volume, at + ivec3(0, 0, f.near / 4u), 0), far_slices);
}

// Fetches a layer's four slices bilinearly, at the layer's own depth, so that the neighbouring layers have no weight.
vec4 bilinear_slices(LookUp l, uint slice) {
    float z = (float(l.map * LAYERS + slice / 4u) + 0.5) / float(textureSize(visibility_volume, 0).z);
    return textureLod(visibility_volume, vec3(l.at / vec2(l.view.width, l.view.height), z), 0.0);
}

float slices_transmittance(LookUp l) {
    if (FILTER != FILTER_BILINEAR) {
        return filtered_transmittance(l);
    }
    Faces f = depth_faces(l.depth);
    vec4 far_slices = bilinear_slices(l, f.face);
    // Slices k and k + 1 share a layer, unless slice k is the layer's last.
    return between(f, f.near / 4u == f.face / 4u ? far_slices : bilinear_slices(l, f.near), far_slices);
}
