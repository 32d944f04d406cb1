#version 460
// shading=interleaved and reservoir, second pass: a pixel's light is the mean over a square of 4 × 4 pixels around it, without pixels that
// see another surface. At edges the square moves to where most of its pixels see the pixel's own surface. Sources: as in ask.comp; Wald et
// al. 2002, Interactive global illumination (a filter that stops at edges); moving the square is ours. Twin:
// reference::twin::interleaved::gather. Inputs: the light that each pixel reflects from its part of the lights, albedo, normal, z. Output:
// color. Invariant: a square of 4 × 4 pixels contains each part of the lights once, wherever the square begins, and all queried lights have
// the same weight. So on one surface the mean is the mean over all lights, and a pixel without neighbours on its surface keeps its own
// part.
// variants: HALF 0 1
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/packed_normal.glsl"
#include "shading/picture_set.glsl"
#include "shading/shading.glsl"
#include "shading/interleaved/parts.glsl"

layout(local_size_x = 16, local_size_y = 8) in;

// Whether each pixel's value represents all lights (reservoir), instead of only the pixel's part of them (interleaved).
CONSTANT(bool, WHOLE, false)

PICTURE_LIGHTS
PICTURE_CAMERA
// set 1: interleaved_read
layout(set = 1, binding = 0, scalar) readonly buffer Estimates { vec3 estimates[]; };
#if HALF == 1
layout(set = 1, binding = 1, rgba16f) writeonly uniform image2D colors;
#else
layout(set = 1, binding = 1, rgba32f) writeonly uniform image2D colors;
#endif
SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES

#include "shading/ambient.glsl"

// As in shading/many_lights/frame.glsl: a pixel's direction is corner + (x + ½) · across + (y + ½) · down.
layout(push_constant, scalar) uniform GatherPush {
    vec3 corner;
    vec3 across;
    vec3 down;
    float edge;  // how far a point may be off a surface and still belong to it, world units per unit of z
    vec3 sky;
};

// Number of pixels that are read beyond the workgroup's own, on each side.
const int REACH = 3;
// How well a run of four pixels is centred on a pixel, for runs that begin 3, 2, 1 or 0 pixels before it; higher is better.
const uint NEARNESS[4] = uint[](0u, 2u, 3u, 1u);
const ivec2 AROUND = ivec2(16, 8) + 2 * REACH;

shared float around_z[AROUND.x * AROUND.y];  // 0 in the sky, and outside the picture
shared uint around_normals[AROUND.x * AROUND.y];
shared vec3 around_light[AROUND.x * AROUND.y];

void main() {
    ivec2 size = ivec2(camera.width, camera.height), pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 from = ivec2(gl_WorkGroupID.xy * gl_WorkGroupSize.xy) - REACH;
    for (int i = int(gl_LocalInvocationIndex); i < AROUND.x * AROUND.y; i += int(gl_WorkGroupSize.x * gl_WorkGroupSize.y)) {
        ivec2 at = from + ivec2(i % AROUND.x, i / AROUND.x);
        around_z[i] = 0.0;
        around_normals[i] = 0u;
        if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size)) && texelFetch(albedos, at, 0).a != 0.0) {
            around_z[i] = texelFetch(distances, at, 0).r;
            around_normals[i] = pack_normal(texelFetch(normals, at, 0).xyz);
            around_light[i] = estimates[at.y * size.x + at.x];
        }
    }
    barrier();
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    int middle = (pixel.y - from.y) * AROUND.x + pixel.x - from.x;
    float z = around_z[middle];
    if (z == 0.0) {
        imageStore(colors, pixel, vec4(sky, 1.0));
        return;
    }
    uint faces = around_normals[middle];
    precise vec3 direction = corner + (float(pixel.x) + 0.5) * across + (float(pixel.y) + 0.5) * down;
    // Distance from the camera, along the normal, of the ray's point at z = 1, and its change per pixel.
    float away = along_normal(faces, direction), by_x = along_normal(faces, across), by_y = along_normal(faces, down);
    precise float plane = z * away, tolerance = float(NORMAL_UNIT) * edge * z;
    // Per row, one bit for each surrounding pixel that sees the same surface.
    uint like[2 * REACH + 1];
    for (int y = -REACH; y <= REACH; ++y) {
        like[y + REACH] = 0u;
        for (int x = -REACH; x <= REACH; ++x) {
            int other = middle + y * AROUND.x + x;
            precise float off = around_z[other] * (away + float(x) * by_x + float(y) * by_y) - plane;
            bool same = around_z[other] > 0.0 && abs(off) <= tolerance && same_normal(faces, around_normals[other]);
            like[y + REACH] |= uint(same || other == middle) << (x + REACH);
        }
    }

    // Choose the square of 4 × 4 with the most pixels on the same surface; on ties, the best centred one.
    uint first_x = 0u, first_y = 0u, most = 0u;
    for (uint y = 0u; y < 4u; ++y) {
        for (uint x = 0u; x < 4u; ++x) {
            uint rows = bitfieldExtract(like[y], int(x), 4) | bitfieldExtract(like[y + 1u], int(x), 4) << 4
                      | bitfieldExtract(like[y + 2u], int(x), 4) << 8 | bitfieldExtract(like[y + 3u], int(x), 4) << 12;
            uint key = 8u * uint(bitCount(rows)) + NEARNESS[x] + NEARNESS[y];
            if (key > most) {
                first_x = x;
                first_y = y;
                most = key;
            }
        }
    }
    precise vec3 sum = vec3(0.0);
    uint count = lights.length(), asked = 0u;
    for (uint y = first_y; y < first_y + 4u; ++y) {
        for (uint x = first_x; x < first_x + 4u; ++x) {
            if ((like[y] >> x & 1u) != 0u) {
                ivec2 to = ivec2(x, y) - REACH;
                sum += around_light[middle + to.y * AROUND.x + to.x];
                asked += WHOLE ? count : part_lights(count, pixel_place(uvec2(pixel + to)));
            }
        }
    }
    vec3 light = asked > 0u ? sum * (float(count) / float(asked)) : vec3(0.0);
    imageStore(colors, pixel, vec4(shade_surface(texelFetch(albedos, pixel, 0).rgb, ambient() + light), 1.0));
}
