#version 460
// Paints one slice of half-angle slicing from near to far, one thread per pixel: over the picture, or behind the slices that are nearer to
// the camera. Source: Kniss et al. 2003. Inputs: lights, camera, casters, their order, items by tile and place, z of the meshes, the
// technique. Output: colors. Twin: reference::twin::half_angle.
#include "shading/shading.glsl"
#include "technique/half_angle/visibility.glsl"
#include "query/receiver.glsl"
#include "shading/picture_set.glsl"
#include "world/triangle.glsl"
#include "shading/painter/picture.glsl"
#include "shading/painter/lists.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_TRIANGLES
PICTURE_SPLATS
PAINTED_DISTANCES
PAINTED_COLORS

// set 3: painter_slices
layout(set = 3, binding = 0, scalar) readonly buffer Sorted { uint sorted[]; };
layout(set = 3, binding = 1, scalar) readonly buffer Items { Item items[]; };
layout(set = 3, binding = 2, scalar) readonly buffer Ranges { uvec2 ranges[]; };
layout(set = 3, binding = 3, scalar) readonly buffer Parts { Part parts[]; };
layout(set = 3, binding = 4, scalar) readonly buffer Totals { PaintTotals totals; };

#include "shading/sheets.glsl"
#include "shading/caster_seen.glsl"
#include "shading/caster_light.glsl"

// Whether slices come from near to far. Then alpha is the fraction of the light from behind that the nearer slices absorb.
CONSTANT(bool, UNDER, false)

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform SlicedPush {
    uint first;  // the place of the slice's first caster in the order
    uint last;   // one past the place of its last caster
};

// Index of a tile's first entry whose caster is at or after `place` in the order.
uint entry_from(uvec2 range, uint place) {
    while (range.x < range.y) {
        uint middle = (range.x + range.y) / 2u;
        if (items[totals.sorted + middle].index < place) {
            range.x = middle + 1u;
        } else {
            range.y = middle;
        }
    }
    return range.x;
}

void main() {
    uint thread = gl_LocalInvocationIndex, listed = gl_WorkGroupID.y * PART_GROUPS + gl_WorkGroupID.x;
    if (listed >= totals.parts) {
        return;
    }
    uint tile = parts[listed].tile;
    uvec2 size = uvec2(camera.width, camera.height), pixel = tile_pixel(size, tile, thread), range = ranges[tile];
    uint begin = entry_from(range, first), end = entry_from(uvec2(begin, range.y), last);
    if (begin == end || any(greaterThanEqual(pixel, size))) {
        return;
    }
    Ray ray = view_ray(camera, vec2(pixel) + 0.5);
    float farthest = texelFetch(distances, ivec2(pixel), 0).r;
    vec4 before = imageLoad(colors, ivec2(pixel));
    vec3 color = vec3(0.0);
    float left = UNDER ? 1.0 - before.a : 1.0;
    for (uint i = begin; i < end; ++i) {
        uint number = sorted[items[totals.sorted + (UNDER ? i : begin + end - 1u - i)].index];
        Caster caster = casters[number];
        vec2 z;
        if (caster_seen(camera, ray, caster, farthest, z)) {
            float middle = 0.5 * (z.x + z.y);
            light_footprint(pixel_side(camera, middle));
            vec3 light = caster_light(caster, ray.origin + middle * ray.direction);
            float opacity = 1.0 - exp(-caster_optical_depth(ray, caster, z));
            color += left * opacity * shade_caster(caster_color_of(caster, number), light);
            left *= 1.0 - opacity;
        }
    }
    vec4 after = UNDER ? vec4(before.rgb + color, 1.0 - left) : vec4(color + left * before.rgb, before.a);
    imageStore(colors, ivec2(pixel), after);
}
