// A texel of a reflective shadow map: the patch of surface that a light sees through it. Sources: Dachsbacher and Stamminger 2005 (the
// maps); deriving a patch from its triangle is ours. Twin: reference::twin::indirect::patch.
#ifndef LIGHTS_INDIRECT_PATCH_GLSL
#define LIGHTS_INDIRECT_PATCH_GLSL
#include "maps/scene.glsl"
#include "maps/opaque.glsl"
#include "shading/surface.glsl"
#include "lights/indirect/luminance.glsl"
#include "lights/indirect/texels.glsl"

// set 1: indirect_lit
layout(set = 1, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
// The light that each map belongs to.
layout(set = 1, binding = 1, scalar) readonly buffer Owners { uint owners[]; };
// Per triangle: 1 if its normal points out of a closed mesh, -1 if it points into one, else 0.
layout(set = 1, binding = 2, scalar) readonly buffer Sides { int sides[]; };
// Index of each texel's triangle, plus 1.
layout(set = 1, binding = 3) uniform utexture2D seen;

const float PI = 3.14159265;

struct Patch {
    vec3 position;
    vec3 normal;     // on the side that faces the light
    vec3 flux;       // flux of a virtual light (world/light.glsl): the radiance that leaves the patch, times its area, over pi
    float crossed;   // cross-section of the light's rays that hit the patch, over pi
    float cosine;    // cosine between the patch's normal and the light's rays
};

const Patch NO_PATCH = Patch(vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, 1.0);

// Returns the patch of a texel: NO_PATCH if the light sees no mesh or the inside of a closed mesh, or if the point belongs to another map
// of the same light.
Patch patch_of(uint texel) {
    uint map = texel_map(texel);
    View view = maps[map].opaque;
    uvec2 at = texel_place(texel);
    uint met = texelFetch(seen, opaque_corner(view, map, opaque_map) + ivec2(at), 0).r;
    if (met == 0u) {
        return NO_PATCH;
    }
    Triangle triangle = triangles[met - 1u];
    Light light = lights[owners[map]];
    Ray ray = view_ray(view, vec2(at) + 0.5);
    vec3 normal = triangle_normal(triangle);
    vec3 z_all = vec3(0.0);
    for (int i = 0; i < 3; ++i) {
        z_all[i] = dot(triangle.corners[i] - view.origin, view.forward);
    }
    vec2 range = vec2(min(z_all.x, min(z_all.y, z_all.z)), max(z_all.x, max(z_all.y, z_all.z)));
    float z = surface_z(ray, Surface(triangle.corners[0], normal, range));
    vec3 position = surface_position(ray, z);
    if (light_map(light, position) != map) {
        return NO_PATCH;
    }
    // An open mesh reflects light from both sides, so the side that faces the light counts. A closed mesh reflects light only from its
    // outside. (At edges of closed meshes, rasterizers may draw triangles that face away from the light.)
    int side = sides[met - 1u];
    float cosine = dot(normal, light_direction(light, position));
    if (side != 0 && (cosine <= 0.0) == (side > 0)) {
        return NO_PATCH;
    }
    normal = cosine < 0.0 ? -normal : normal;
    // In perspective a texel is a pyramid of rays: its cross-section is its solid angle times the distance squared.
    float slant = length(ray.direction);
    float crossed = 4.0 / (float(view.width) * float(view.height) * view.scale_x * view.scale_y * PI);
    crossed *= view.projection == VIEW_PARALLEL ? 1.0 : z * z / slant;
    return Patch(position, normal, triangle.albedo * light_radiance(light, position) * crossed, crossed, abs(cosine));
}

// Smaller cosines count as this one, which bounds the area of patches lit at grazing angles.
const float LEAST_COSINE = 0.1;

// Returns the area of the surface that a texel shows, over pi.
float patch_area(Patch lit) { return lit.crossed / max(lit.cosine, LEAST_COSINE); }
#endif
