#version 460
// Shades a caster by single scattering. In a sphere, light is looked up at the midpoint of the camera ray's segment inside the sphere; on a
// strand, at the strand's lit side. Inputs: lights, camera, casters, z of the meshes, the technique. Output: premultiplied color, blended
// over.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/shading.glsl"
#include "visibility.glsl"
#include "query/receiver.glsl"
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"
#include "world/triangle.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_TRIANGLES
PICTURE_SPLATS
PICTURE_DISTANCES

#include "shading/sheets.glsl"
#include "shading/caster_seen.glsl"
#include "shading/caster_light.glsl"

layout(location = 0) flat in uint caster_index;
layout(location = 0) out vec4 color;

void main() {
    Caster caster = casters[channel_casters() + caster_index];
    Ray ray = view_ray(camera, gl_FragCoord.xy);
    vec2 z;
    if (!caster_seen(camera, ray, caster, texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r, z)) {
        discard;
    }
    vec3 position = ray.origin + 0.5 * (z.x + z.y) * ray.direction;
    light_footprint(pixel_side(camera, 0.5 * (z.x + z.y)));
    // The color is read after the look-up, so that it need not be kept in registers meanwhile.
    vec3 light = caster_light(caster, position);
    color = caster_color(ray, caster, caster_color_of(caster, caster_index), z, light);
}
