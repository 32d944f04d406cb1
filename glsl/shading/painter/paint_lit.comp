#version 460
// lighting=vertex: paints casters with the light at their vertices. Inputs: casters, items, parts, z of the meshes, patches, vertex_light.
// Outputs: colors, layers. Twin: reference::twin::vertex_lit. Invariant: between vertices light is bilinear.
#include "shading/shading.glsl"
#include "shading/camera_push.glsl"
#include "shading/painter/patches.glsl"
#include "shading/painter/picture.glsl"
#include "shading/painter/set.glsl"

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

// set 1: painter_patches
layout(set = 1, binding = 0, scalar) readonly buffer Patches { Patch patches[]; };
layout(set = 1, binding = 1, scalar) readonly buffer VertexLight { vec3 vertex_light[]; };

#include "shading/sheets.glsl"
#include "shading/caster_seen.glsl"

vec3 light_within(View camera, Caster caster, uint number, uvec2 pixel, float z, vec3 position) {
    Patch quad = patches[number];
    uvec2 level = uvec2(quad.parts & 0xFFFFu, quad.parts >> 16u);
    if (level.x == 0u) {
        return vec3(0.0);
    }
    vec2 ndc = 2.0 * (vec2(pixel) + 0.5) / vec2(size) - 1.0;
    vec2 at = clamp((ndc - quad.corners.xy) / (quad.corners.zw - quad.corners.xy), 0.0, 1.0) * vec2(level);
    uvec2 part = min(uvec2(at), level - 1u);
    uint row = level.x + 1u, corner = quad.first + part.y * row + part.x;
    at -= vec2(part);
    vec3 low = mix(vertex_light[corner], vertex_light[corner + 1u], at.x);
    vec3 high = mix(vertex_light[corner + row], vertex_light[corner + row + 1u], at.x);
    return mix(low, high, at.y);
}

#include "shading/painter/paint.glsl"
