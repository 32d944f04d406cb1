#version 460
// Places a corner of a point in its light's map. The point is drawn as a square or a triangle around its centre, with the area of its disc,
// facing the light. Sources: Ritschel et al. 2008, Tokuyoshi 2014. Inputs: the list, or lights and points. Outputs: the position in the
// target, and the upper left texel of the map that the point must stay in.
#define ATLAS_ACCESS readonly
#include "technique/ism/atlas.glsl"
#include "technique/ism/drawn.glsl"

layout(set = 0, binding = 7, scalar) readonly buffer DrawListed { vec4 listed[]; };

layout(location = 0) flat out uvec2 corner;

// A square and a triangle with the area of a disc of radius 1: the half-extent of the square, and the distance from the centre of the
// triangle to its corners.
const float SQUARE = 0.88622693;
const float TRIANGLE = 1.55512030;

// Returns point `drawn` among all points of all lights. Its radius is 0 if the point is not in front of the light's plane, or if the light
// takes fewer points.
vec4 point_at(uint drawn) {
    uint light = drawn / points;
    IsmPoint point;
    float radius;
    Bounds bounds;
    bool takes = take(light, drawn % points, point, radius, bounds);
    precise vec3 offset = point.position - lights[light].position;
    bool before = takes && is_before(lights[light].position, lights[light].direction, offset);
    return before ? drawn_point(light, axes_of(lights[light].direction), offset, radius, head.radius) : vec4(0.0);
}

void main() {
    uint drawn = gl_VertexIndex / DRAWN_VERTICES, vertex = gl_VertexIndex % DRAWN_VERTICES;
    vec4 point = DRAWN_LISTED ? listed[drawn] : point_at(drawn);
    corner = uvec2(point.xy) / ISM_SIZE * ISM_SIZE;
    if (point.z == 0.0) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // outside the clip volume
        return;
    }
    vec2 about;
    if (DRAWN_VERTICES == 6u) {
        uint place = vertex < 3u ? vertex : vertex - 2u;  // 0 1 2, 1 2 3
        about = SQUARE * (2.0 * vec2(place & 1u, place >> 1u) - 1.0);
    } else {
        float angle = float(vertex) * 2.0943951;
        about = TRIANGLE * vec2(sin(angle), cos(angle));
    }
    uvec2 size = uvec2(COLUMNS, (light_count + COLUMNS - 1u) / COLUMNS) * ISM_SIZE;
    gl_Position = vec4((point.xy + about * point.z) / vec2(size) * 2.0 - 1.0, point.w, 1.0);
}
