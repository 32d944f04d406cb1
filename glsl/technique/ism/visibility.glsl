// Imperfect shadow map look-up: how much of virtual light `light` reaches `position`, 0 to 1. Sources: Ritschel et al. 2008; Reeves,
// Salesin and Cook 1987 (four comparisons, averaged). Call light_receiver with a surface's normal before each look-up. Twin:
// reference::twin::ism::look_up.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  totals over all points (technique/ism/points.glsl)
//   binding 2  maps, ISM_STRIDE texels apart, rows of distances as float bits
// flat: bindings 16, constants 32: ISM_SIZE ISM_STRIDE
#include "technique/ism/map.glsl"
#include "technique/ism/points.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityPoints { IsmPoints visibility_points; };
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityMaps { uint visibility_maps[]; };

// Texels from one map to the next.
CONSTANT(uint, ISM_STRIDE, 4096u)

// Normal of a surface point, which light_receiver sets for the next look-up; 0 for a point in space.
vec3 visibility_normal = vec3(0.0);

// A caster shadows a surface only if it is nearer to the light than the surface by at least this many texels, more than the error from
// rounding and from the points' planes.
const float NEARER_TEXELS = 0.5;
// Sine of the angle beyond which a surface that faces away from the light is dark for that reason alone.
const float AWAY = 1e-4;
// Twins: technique/ism/splat.glsl, WIDEST; 1 + 2 BESIDE / WIDEST.
const float WIDEST = 3.0;
const float REACH = 1.2;

// Does not move a surface point, but keeps its normal for the look-up.
#define TECHNIQUE_RECEIVERS
vec3 light_receiver(uint light, vec3 position, vec3 normal) {
    visibility_normal = normal;
    return position;
}

// Returns the distance from the light to a surface's plane, along the ray through the centre of a texel. `plane`: the dot product of the
// plane's normal and any point of the plane. Points of the surface may also have been splatted into a coarser map, into the texel that
// contains this one. The plane's distance at the centre of that texel therefore counts too, and the least distance is returned. A coarser
// map counts only if points of the plane may have been splatted into it: there, `along` is half of `ahead` in splat.glsl, which changes by
// at most 2 per unit, and a disc reaches 1 + 2 BESIDE / WIDEST radii. The result is at most `distance`, the distance of the point that is
// looked up: farther out, a slanted plane would lie behind objects that stand on it. It is at least half of `distance`, as in own_distance.
float surface_distance(vec3 normal, float plane, ivec2 texel, float distance) {
    float least = distance;
    for (uint level = 0u; level_side(level) >= 4u; ++level) {
        uint side = level_side(level);
        float splatted = level == 0u ? FARTHEST : visibility_points.radius * (REACH + float(side) / (2.0 * WIDEST));
        if (0.25 * distance > splatted) {
            break;
        }
        vec3 way = map_way(texel_place(level, texel * int(side) / int(ISM_SIZE)));
        float along = plane / dot(normal, way);
        if (along > 0.0 && along < splatted) {
            least = min(least, along * (2.0 - way.z));
        }
    }
    return max(least, 0.5 * distance);
}

float light_visibility(uint light, vec3 position) {
    Light l = visibility_lights[light];
    Axes axes = axes_of(l.direction);
    vec3 offset = into_axes(axes, position - l.position), normal = into_axes(axes, visibility_normal);
    bool on_surface = dot(visibility_normal, visibility_normal) > 0.0;
    visibility_normal = vec3(0.0);
    float square = dot(offset, offset);
    // A light emits nothing behind its plane, so nothing is shadowed there. A NaN position is not looked up. Without points, nothing casts
    // a shadow.
    if (!(offset.z > 0.0) || !(square < FARTHEST) || visibility_points.total == 0u) {
        return 1.0;
    }
    float distance = sqrt(square), plane = dot(normal, offset);
    // A closed mesh shadows its own sides that face away from the light; on an open mesh, the side towards the light is looked up.
    if (plane > AWAY * distance) {
        return 0.0;
    }
    float nearer = on_surface ? NEARER_TEXELS * (distance + offset.z) * (2.0 / float(ISM_SIZE)) : 0.0;
    vec2 at = (offset.xy / (distance + offset.z) * 0.5 + 0.5) * float(ISM_SIZE) - 0.5;
    vec2 low = floor(at), part = at - low;
    ivec2 last = ivec2(ISM_SIZE - 1u);
    float lit[4];
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = clamp(ivec2(low) + ivec2(i & 1, i >> 1), ivec2(0), last);
        float nearest = uintBitsToFloat(visibility_maps[light * ISM_STRIDE + uint(texel.y) * ISM_SIZE + uint(texel.x)]);
        float here = on_surface ? surface_distance(normal, plane, texel, distance) - nearer : distance;
        lit[i] = here <= nearest ? 1.0 : 0.0;
    }
    // With this formula, four comparisons that agree give exactly 0 or 1.
    vec2 rows = vec2(lit[0] + part.x * (lit[1] - lit[0]), lit[2] + part.x * (lit[3] - lit[2]));
    return rows.x + part.y * (rows.y - rows.x);
}
