#version 460
// Aims the views of all maps for lights that only the device knows. Twin: reference::twin::fit::aim; its truth is View::aimed, in f64. One
// thread per light. Inputs: lights; maps that were aimed for other lights of the same kinds. Output: maps: the origin and direction of each
// view, and the width of a spot light's view.
#include "world/light.glsl"

layout(local_size_x = 64) in;

// set 0: maps_aim
layout(set = 0, binding = 0, scalar) buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer AimLights { Light lights[]; };

layout(push_constant, scalar) uniform AimPush {
    uint light_count;
    uint map_count;
    uint cascade_maps;  // number of maps of all lights in one cascade; the cascades are stored back to back
};

void aim(inout View view, Light light) {
    if (light.kind != LIGHT_DIRECTIONAL) {
        view.origin = light.position;
    }
    // The faces of a cube look along the world's axes.
    if (light.map_count != 1u) {
        return;
    }
    vec3 forward = light.direction;
    // Perpendicular to `forward` and the world's z axis, or to the y axis if `forward` is close to z.
    vec3 right = abs(forward.z) < 0.99 ? vec3(forward.y, -forward.x, 0.0) : vec3(-forward.z, 0.0, forward.x);
    // Used instead of `normalize`: if one of the two coordinates is 0, the result is exact on every device whose square root and division
    // are exact.
    right /= sqrt(dot(right, right));
    view.right = right;
    view.up = cross(right, forward);
    view.forward = forward;
    if (light.kind == LIGHT_SPOT) {
        float cosine = light.cos_cone;
        view.scale_x = cosine / sqrt((1.0 - cosine) * (1.0 + cosine));
        view.scale_y = view.scale_x;
    }
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= light_count) {
        return;
    }
    Light light = lights[i];
    for (uint first = light.first_map; first < map_count; first += cascade_maps) {
        for (uint face = 0u; face < light.map_count; ++face) {
            Map map = maps[first + face];
            aim(map.caster_view, light);
            aim(map.opaque, light);
            maps[first + face] = map;
        }
    }
}
