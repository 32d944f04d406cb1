#version 460
// Creates virtual lights from the chosen texels: each gets an equal share of the total weight, with its texel's color and flux. Inputs:
// picks, fluxes, maps, triangles, lights. Output: virtual lights. Twin: reference::twin::indirect::light.
#include "lights/indirect/drawn.glsl"
#include "lights/indirect/patch.glsl"

layout(local_size_x = 64) in;

// set 2: indirect_drawn
layout(set = 2, binding = 5, scalar) writeonly buffer VirtualLights { Light virtual_lights[]; };

layout(push_constant, scalar) uniform DrawPush {
    uint light_count;
    uint map_count;
};

// Distance of a virtual light from its surface, as a share of the patch's coordinates and of the patch's distance from the light that it
// reflects. The share is well above float rounding error, so that the surface is behind the virtual light and shadows nothing.
const float LIFT = 1e-5;

void main() {
    uint i = gl_WorkGroupID.x * 64u + gl_LocalInvocationIndex;
    if (i >= light_count) {
        return;
    }
    uint texel = picks[i];
    Patch lit = texel == NO_TEXEL ? NO_PATCH : patch_of(texel);
    // The weight that the texel was drawn by: the luminance of its flux, or the luminance times its importance.
    float own = texel == NO_TEXEL ? 0.0 : fluxes[texel];
    uvec2 total = starts[map_count << SIDE_BITS];
    float share = (float(total.y) * 4294967296.0 + float(total.x)) * flux_unit(greatest) / float(light_count);
    // The area that emits one light's share of the flux, over pi; at least the texel's own area, even if several lights are drawn from the
    // texel.
    float area = own > 0.0 ? patch_area(lit) * max(share / own, 1.0) : 1.0;
    vec3 far = abs(lit.position);
    float lift = 0.0;
    if (own > 0.0) {
        lift = LIFT * (max(far.x, max(far.y, far.z)) + distance(lit.position, maps[texel_map(texel)].opaque.origin));
    }
    Light light;
    light.position = lit.position + lift * lit.normal;
    light.kind = LIGHT_VIRTUAL;
    light.direction = lit.normal;
    light.cos_cone = 0.0;
    light.radiance = own > 0.0 ? lit.flux * (share / own * min(BRIGHTEST / luminance(lit.flux), 1.0)) : vec3(0.0);
    light.falloff = 1.0 / area;
    light.first_map = 6u * i;
    light.map_count = 6u;
    light.has_opaque = 1u;
    virtual_lights[i] = light;
}
