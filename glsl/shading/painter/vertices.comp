#version 460
// lighting=vertex: computes the light at the vertices of casters' quads. A workgroup's threads share the vertices of its casters evenly.
// Inputs: lights, camera, casters, order, z of the meshes, the technique. Outputs: patches, vertex_light, counts.
// Twin: reference::twin::vertex_lit.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/painter/patches.glsl"
#include "shading/picture_set.glsl"
#include "shading/vertex_lit.glsl"
#include "world/light.glsl"
#include "visibility.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_ORDER

// set 2: painter_vertices
layout(set = 2, binding = 0) uniform texture2D distances;
layout(set = 2, binding = 1, scalar) writeonly buffer Patches { Patch patches[]; };
layout(set = 2, binding = 2, scalar) writeonly buffer VertexLight { vec3 vertex_light[]; };
layout(set = 2, binding = 3, scalar) buffer Counts {
    uint wanted;       // number of vertices needed for this run of casters, which may exceed the capacity
    uint most_wanted;  // greatest `wanted` of all runs of the frame
} counts;

#include "shading/caster_light.glsl"

layout(push_constant, scalar) uniform VerticesPush {
    float spacing;  // largest distance between neighbouring vertices, in pixels
    uint first;     // the first caster's place in the order
    uint count;     // number of casters
    uint capacity;  // capacity, in vertices
    uint counts_only;
};

// More vertices than the buffer can ever hold. Counting stops at this number, so that the sum fits into a word.
const uint FULL = 1u << 30u;

// Number of casters per workgroup, and of threads.
const uint GROUP = 64u;

layout(local_size_x = GROUP) in;

shared uint ends[GROUP];
shared vec4 group_corners[GROUP];
shared uvec2 group_levels[GROUP];
shared uint group_casters[GROUP];
shared uint base;

void light_vertex(uint k, uint within) {
    Caster caster = casters[group_casters[k]];
    vec4 corners = group_corners[k];
    vec2 level = vec2(group_levels[k]);
    uint row = group_levels[k].x + 1u;
    vec2 pixel = vertex_pixel(camera, corners, vec2(within % row, within / row) / level);
    vec2 last = vec2(camera.width, camera.height) - 1.0;
    float farthest = texelFetch(distances, ivec2(clamp(pixel, vec2(0.0), last)), 0).r;
    vec3 asked = caster_asked(camera, view_ray(camera, pixel), caster, farthest);
    light_footprint(vertex_side(camera, corners, level) * pixel_side(camera, dot(asked - camera.origin, camera.forward)));
    vertex_light[base + (k > 0u ? ends[k - 1u] : 0u) + within] = caster_light(caster, asked);
}

void main() {
    uint thread = gl_LocalInvocationIndex, i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * GROUP + thread;
    uint own = 0u;
    if (i < count) {
        uint number = order[first + i];
        vec2 level;
        vec4 corners;
        if (lit_quad(camera, casters[number], spacing, corners, level)) {
            own = (uint(level.x) + 1u) * (uint(level.y) + 1u);
        }
        group_corners[thread] = corners;
        group_levels[thread] = uvec2(level);
        group_casters[thread] = number;
    }
    ends[thread] = own;
    for (uint reach = 1u; reach < GROUP; reach *= 2u) {
        barrier();
        uint other = thread >= reach ? ends[thread - reach] : 0u;
        barrier();
        ends[thread] += other;
    }
    barrier();
    if (thread == 0u) {
        uint all = ends[GROUP - 1u];
        base = counts.wanted > FULL ? FULL : atomicAdd(counts.wanted, all);
        atomicMax(counts.most_wanted, base + all);
    }
    barrier();
    if (counts_only != 0u) {
        return;
    }
    uint all = ends[GROUP - 1u];
    bool has_room = base <= capacity && all <= capacity - base;
    if (own > 0u) {
        uvec2 level = group_levels[thread];
        uint parts = has_room ? level.x | level.y << 16u : 0u;
        patches[group_casters[thread]] = Patch(group_corners[thread], base + ends[thread] - own, parts);
    }
    for (uint v = thread; has_room && v < all; v += GROUP) {
        // The first caster whose vertices end after v.
        uint k = 0u;
        for (uint reach = GROUP / 2u; reach > 0u; reach /= 2u) {
            k += ends[k + reach - 1u] <= v ? reach : 0u;
        }
        light_vertex(k, v - (k > 0u ? ends[k - 1u] : 0u));
    }
}
