#version 460
// A corner of a point in its light's map: a square, or a triangle about the same middle, of the disc's area, facing the light. Sources:
// Ritschel et al. 2008, Tokuyoshi 2014. Inputs: lights, points, the list. Outputs: where it is in the target, which map it may not leave.
#define ATLAS_ACCESS readonly
#include "ism/atlas.glsl"
#include "ism/drawn.glsl"

layout(set = 0, binding = 5, scalar) readonly buffer DrawListed { uint listed[]; };

layout(location = 0) flat out uvec2 corner;

// Half the side of a square, and how far a corner of a triangle is from its middle, of the area of a disc of radius 1.
const float SQUARE = 0.88622693;
const float TRIANGLE = 1.55512030;

void main() {
    uint drawn = gl_VertexIndex / DRAWN_VERTICES, vertex = gl_VertexIndex % DRAWN_VERTICES;
    uint item = DRAWN_LISTED ? listed[drawn] : drawn;
    uint light = item / points;
    uvec2 size = uvec2(COLUMNS, (light_count + COLUMNS - 1u) / COLUMNS) * ISM_SIZE;
    corner = map_corner(light, ISM_SIZE);
    precise vec3 way = pool[point_of(light, item % points, points)].position - lights[light].position;
    if (!is_before(lights[light].position, lights[light].direction, way)) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // nowhere
        return;
    }
    vec3 offset = into_axes(axes_of(lights[light].direction), way);
    float distance = length(offset), ahead = distance + offset.z;
    // At least half a texel, so that the texel that it is in has it.
    float reach = max(head.radius / ahead * (0.5 * float(ISM_SIZE)), 0.57);
    vec2 about;
    if (DRAWN_VERTICES == 6u) {
        uint place = vertex < 3u ? vertex : vertex - 2u;  // 0 1 2, 1 2 3
        about = SQUARE * (2.0 * vec2(place & 1u, place >> 1u) - 1.0);
    } else {
        float angle = float(vertex) * 2.0943951;
        about = TRIANGLE * vec2(sin(angle), cos(angle));
    }
    vec2 at = (offset.xy / ahead * 0.5 + 0.5) * float(ISM_SIZE) + about * reach + vec2(corner);
    gl_Position = vec4(at / vec2(size) * 2.0 - 1.0, drawn_depth(distance, head.radius), 1.0);
}
