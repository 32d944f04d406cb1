#version 460
// lighting=vertex, second stage: passes on a caster's quad, as large as caster_corner draws it, and says into how many parts it is cut
// along x and y, by its size on the screen. Source: Fife and Strugar 2013, Tessellation. Twin: reference::twin::vertex_lit. Inputs: camera,
// casters. Outputs: the quad, levels. Invariant: casters off the screen have level 0 and no triangles.
#include "consume/picture_set.glsl"
#include "world/caster.glsl"

layout(vertices = 1) out;

PICTURE_CAMERA
PICTURE_CASTERS

layout(push_constant, scalar) uniform SpacingPush {
    float spacing;  // pixels from vertex to vertex, at most
};

// What every device with tessellation can do.
const float MAX_LEVEL = 64.0;

// Into how many parts a side of a caster's quad is cut. `pixels`: the side's length. A side of one part has vertices only at its ends, on
// the caster's silhouette or past it, where there is more light than inside. So a side is cut into two parts from half of `spacing` on. A
// smaller caster is not cut: it has fewer pixels than 2 × 2 parts have vertices, which is nine.
float parts(float pixels) {
    return clamp(ceil(pixels / spacing), pixels > 0.5 * spacing ? 2.0 : 1.0, MAX_LEVEL);
}

layout(location = 0) in uint caster_index[];
layout(location = 0) patch out uint patch_caster;
layout(location = 1) patch out vec4 patch_corners;  // NDC, low then high

void main() {
    vec2 low, high;
    bool seen = caster_bounds(camera, casters[caster_index[0]], low, high)
             && all(lessThan(low, vec2(1.0))) && all(greaterThan(high, vec2(-1.0)));
    low = clamp(low, -1.1, 1.1);
    high = clamp(high, -1.1, 1.1);
    vec2 pixels = 0.5 * (high - low) * vec2(camera.width, camera.height);
    vec2 level = seen ? vec2(parts(pixels.x), parts(pixels.y)) : vec2(0.0);
    gl_TessLevelOuter[0] = gl_TessLevelOuter[2] = gl_TessLevelInner[1] = level.y;
    gl_TessLevelOuter[1] = gl_TessLevelOuter[3] = gl_TessLevelInner[0] = level.x;
    patch_caster = caster_index[0];
    patch_corners = vec4(low, high);
}
