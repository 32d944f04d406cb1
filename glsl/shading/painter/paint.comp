#version 460
// Paints casters, each shaded at each pixel as in caster.frag. Inputs: lights, casters, items, parts, z of the meshes, the technique.
// Outputs: colors, layers. Twin: reference::truth::picture.
#include "shading/shading.glsl"
#include "visibility.glsl"
#include "shading/camera_push.glsl"
#include "query/receiver.glsl"
#include "shading/painter/picture.glsl"
#include "shading/painter/set.glsl"

PAINTED_LIGHTS
PAINTED_CASTERS
PAINTED_TRIANGLES
PAINTED_SPLATS
PAINTED_ITEMS
PAINTED_RANGES
PAINTED_PARTS
PAINTED_TOTALS
PAINTED_LAYERS
PAINTED_BOXES
PAINTED_DISTANCES
PAINTED_COLORS

#include "shading/sheets.glsl"
#include "shading/caster_seen.glsl"
#include "shading/caster_light.glsl"

// `z` is along the camera's axis.
vec3 light_within(View camera, Caster caster, uint number, uvec2 pixel, float z, vec3 position) {
    light_footprint(pixel_side(camera, z));
    return caster_light(caster, position);
}

#include "shading/painter/paint.glsl"
