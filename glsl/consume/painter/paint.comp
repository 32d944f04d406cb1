#version 460
// Paints casters, each shaded at each pixel, as caster.frag does it. Inputs: lights, casters, items, parts, z of the meshes, the technique.
// Outputs: colors, layers. Twin: reference::truth::picture.
#include "consume/shading.glsl"
#include "visibility.glsl"
#include "consume/camera_push.glsl"
#include "consume/receiver.glsl"
#include "consume/painter/picture.glsl"
#include "consume/painter/set.glsl"

PAINTED_LIGHTS
PAINTED_CASTERS
PAINTED_SPLATS
PAINTED_ITEMS
PAINTED_RANGES
PAINTED_PARTS
PAINTED_TOTALS
PAINTED_LAYERS
PAINTED_BOXES
PAINTED_DISTANCES
PAINTED_COLORS

#include "consume/caster_seen.glsl"
#include "consume/caster_light.glsl"

// `z` is along the camera's axis.
vec3 light_within(View camera, Caster caster, uint number, uvec2 pixel, float z, vec3 position) {
    light_footprint(pixel_side(camera, z));
    return caster_light(caster, position);
}

#include "consume/painter/paint.glsl"
