#version 460
// Makes a caster of each see-through triangle of the caller's, one thread per triangle; other triangles, and those without an area, become
// casters of radius 0, which cast no shadow. A texture's greatest alpha counts as 1. Source: ours. Input: the triangles and their alpha
// (glsl/world/alpha.glsl). Output: casters from `first` on. Twin: scene::model::sheet.
layout(local_size_x = 64) in;
#include "world/caster.glsl"
#include "world/triangle.glsl"

layout(push_constant, scalar) uniform SheetsPush {
    uint first;
    uint slots;  // number of casters to write, and of triangles
};

// set 0: gather_sheets
layout(set = 0, binding = 0, scalar) readonly buffer GatherTriangles { Triangle triangles[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer GatherCasters { Caster casters[]; };

#define ALPHA_TRIANGLES triangles
#include "world/alpha.glsl"

// Bits that keep the lower half of a triangle's number from being a denormal. Twin: NUMBER in scene::model::sheet.
const uint SHEET_NUMBER = 0x3F800000u;
// Enlarges the sphere by more than its centre and radius are rounded by. The host rounds once and needs less.
const float SHEET_MARGIN = 2e-6;

// Centre and radius of a sphere around a triangle, with its centre in the triangle's plane: about the middle of the longest side, or
// through all corners.
vec4 sphere_around(vec3 corners[3]) {
    vec3 squares;
    for (uint i = 0u; i < 3u; ++i) {
        vec3 side = corners[(i + 1u) % 3u] - corners[i];
        squares[i] = dot(side, side);
    }
    uint longest = squares.x >= squares.y && squares.x >= squares.z ? 0u : squares.y >= squares.z ? 1u : 2u;
    vec3 from = corners[longest], to = corners[(longest + 1u) % 3u], third = corners[(longest + 2u) % 3u];
    vec3 centre = from + 0.5 * (to - from), b = to - from, c = third - from, normal = cross(b, c);
    float square = dot(normal, normal);
    if (distance(centre, third) > 0.5 * length(b) && square > 0.0) {
        centre = from + (dot(c, c) * cross(normal, b) + dot(b, b) * cross(c, normal)) / (2.0 * square);
    }
    return vec4(centre, max(distance(centre, from), max(distance(centre, to), distance(centre, third))));
}

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    if (i >= slots) {
        return;
    }
    Caster sheet = Caster(vec3(0.0), 0.0, vec3(0.0), 0.0);
    if (alpha_sees_through(i)) {
        Alpha alpha = alpha_record(alpha_number(i));
        vec3 corners[3] = triangles[i].corners;
        vec4 sphere = sphere_around(corners);
        vec3 far = max(abs(corners[0]), max(abs(corners[1]), abs(corners[2])));
        float most = max(alpha.factors[0], max(alpha.factors[1], alpha.factors[2]));
        float optical_depth = most < 1.0 ? min(-log(1.0 - most), MAX_OPTICAL_DEPTH) : MAX_OPTICAL_DEPTH;
        bool stands = sphere.w > 0.0 && sphere.w < 1e30 && optical_depth > 0.0;
        vec2 places = alpha.uvs[0] + alpha.uvs[1] + alpha.uvs[2];
        if (stands && !any(isnan(places)) && !any(isinf(places))) {
            float radius = sphere.w + SHEET_MARGIN * (sphere.w + max(far.x, max(far.y, far.z)));
            vec3 axis = vec3(uintBitsToFloat(SHEET_MARK | i >> 16u), uintBitsToFloat(SHEET_NUMBER | i & 0xFFFFu), optical_depth);
            sheet = Caster(sphere.xyz, radius, axis, optical_depth);
        }
    }
    casters[first + i] = sheet;
}
