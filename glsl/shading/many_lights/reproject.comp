#version 460
// history=on: finds the pixel that saw each pixel's surface in the previous frame. There is no such pixel if the surface was outside the
// picture or hidden. It was hidden if the surface seen by the earlier pixel is elsewhere or faces another way. Source: Nehab et al. 2007
// (reverse reprojection). Twin: reference::twin::many_lights::reproject. Inputs: the surfaces that both frames see. Output: sources.
#include "shading/many_lights/geometry.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

uint source(uvec2 pixel) {
    uvec2 here = geometry[pixel_index(pixel)];
    Frame now = frames[0], before = frames[1];
    if (has_before == 0u || here.x == 0u) {
        return NOWHERE;
    }
    float z = uintBitsToFloat(here.x);
    precise vec3 position = now.camera.origin + z * frame_direction(now, pixel);
    precise vec3 offset = position - before.camera.origin;
    precise float ahead = offset.x * before.camera.forward.x + offset.y * before.camera.forward.y
                        + offset.z * before.camera.forward.z;
    vec2 texel = view_project(before.camera, position).xy;
    if (!(ahead > before.camera.near) || !all(greaterThanEqual(texel, vec2(0.0))) || !all(lessThan(texel, vec2(size)))) {
        return NOWHERE;
    }
    uvec2 was = min(uvec2(texel), size - 1u);
    uvec2 there = geometry_before[pixel_index(was)];
    if (there.x == 0u || !same_normal(here.y, there.y)) {
        return NOWHERE;
    }
    precise vec3 between = offset - uintBitsToFloat(there.x) * frame_direction(before, was);
    return abs(along_normal(here.y, between)) <= float(NORMAL_UNIT) * before.edge * ahead ? pixel_index(was) : NOWHERE;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, size))) {
        sources[pixel_index(pixel)] = source(pixel);
    }
}
