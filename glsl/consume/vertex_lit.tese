#version 460
// lighting=vertex, third stage: light that arrives at a vertex of a caster's quad. Source: Fife and Strugar 2013, Tessellation and
// Bavoil and Jansen 2013, Particle Lighting with DX11. Twin: reference::twin::vertex_lit.
// Inputs: lights, camera, casters, z of the meshes, the technique. Output: light.
// Invariant: w is 1, so that light runs linearly over the screen between vertices, whatever the interpolation.
#extension GL_EXT_samplerless_texture_functions : require
#include "consume/distances_set.glsl"
#include "consume/picture_set.glsl"
#include "world/caster.glsl"
#include "world/light.glsl"
#include "visibility.glsl"

layout(quads, equal_spacing) in;

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_DISTANCES

#include "consume/caster_light.glsl"

layout(location = 0) patch in uint patch_caster;
layout(location = 1) patch in vec4 patch_corners;
layout(location = 0) flat out uint caster_index;
layout(location = 1) out vec3 light;

// Where a vertex asks for its light. On a sphere: where caster.frag asks, at the middle of the stretch that the vertex's ray has inside the
// sphere. If the ray misses the sphere, at the sphere's point nearest to the ray, since farther out there may be more light than anywhere
// inside. A mesh that cuts the sphere cuts the stretch too. A mesh in front of the whole sphere is ignored: it hides this vertex, but
// perhaps not the pixels beside it. On a strand: at the point of the axis that is nearest to the ray, since most of a strand's quad is far
// from the strand.
vec3 caster_asked(Ray ray, Caster caster, float farthest) {
    if (caster_is_strand(caster)) {
        vec3 start, axis;
        float along;
        bool wide = strand_along(ray, caster, start, axis, along);
        return caster.position + (wide ? clamp(along, 0.0, 1.0) : 0.5) * caster.axis;
    }
    float square = dot(ray.direction, ray.direction);
    float middle = dot(caster.position - ray.origin, ray.direction) / square;
    vec3 across = ray.origin + middle * ray.direction - caster.position;
    float half_chord = sqrt(max(caster.radius * caster.radius - dot(across, across), 0.0) / square);
    bool in_front = farthest < middle - caster.radius * inversesqrt(square);
    vec2 z = max(min(middle + vec2(-half_chord, half_chord), in_front ? camera.far : farthest), camera.near);
    across *= caster.radius / max(length(across), caster.radius);
    return caster.position + across + (0.5 * (z.x + z.y) - middle) * ray.direction;
}

void main() {
    Caster caster = casters[patch_caster];
    vec2 corner = mix(patch_corners.xy, patch_corners.zw, gl_TessCoord.xy);
    vec2 size = vec2(camera.width, camera.height);
    vec2 pixel = (0.5 * corner + 0.5) * size;
    float farthest = texelFetch(distances, ivec2(clamp(pixel, vec2(0.0), size - 1.0)), 0).r;
    vec3 asked = caster_asked(view_ray(camera, pixel), caster, farthest);
    // A vertex stands for what is as near to it as to no other: so many pixels.
    vec2 apart = 0.5 * (patch_corners.zw - patch_corners.xy) * size / vec2(gl_TessLevelInner[0], gl_TessLevelInner[1]);
    light_footprint(sqrt(apart.x * apart.y) * pixel_side(camera, dot(asked - camera.origin, camera.forward)));
    light = caster_light(caster, asked);
    caster_index = patch_caster;
    gl_Position = vec4(corner, 0.5, 1.0);
}
