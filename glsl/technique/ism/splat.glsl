// Splats a point into a light's map as a disc, at the level where it is at most 7 texels wide. Sources: Ritschel et al. 2008; Tokuyoshi
// 2014 (culling of points). Twin: reference::twin::ism::splat.
#ifndef TECHNIQUE_ISM_SPLAT_GLSL
#define TECHNIQUE_ISM_SPLAT_GLSL
#include "technique/ism/map.glsl"
#include "technique/ism/points.glsl"

// Which sides of closed meshes are culled. Twin: technique::Culling.
const uint CULL_NONE = 0u;
const uint CULL_NEAR = 1u;  // sides that face the light
const uint CULL_FAR = 2u;   // sides that face away from the light
CONSTANT(uint, ISM_CULLING, 1u)
// Whether only the normals of light and point decide which side of a point the light sees, as in Tokuyoshi 2014.
CONSTANT(bool, ISM_SLIDE, false)

// Maximum radius of a point on a level, in texels; larger points go to the next level.
const float WIDEST = 3.0;

// Distance, in texels, by which a disc may miss the centre of a texel and still cover the texel, so that discs between texel centres leave
// few gaps.
const float BESIDE = 0.3;

// The texel that contains a point stores the distance of the point's plane at the texel's centre. This distance may exceed the point's own
// by the disc's radius, or by this many texels if the disc is smaller. On a map of 32 texels, a plane seen at 30° is that much farther at
// the texel's centre than at the point. Distant surfaces thus stay flat as well.
const float DEEP = 1.5;

// Axis-aligned box, in world axes, at which a disc is cut off.
struct Bounds {
    vec3 middle;
    vec3 sides;  // half-extents
};

// Whether each light chooses its points (technique/ism/adapt.comp). The discs of such points are cut off at their bounds.
CONSTANT(bool, ISM_ADAPTIVE, false)

// The texel that contains a point stores the point even if its disc misses the texel's centre. With adaptive points, it does so only if the
// point is this close to the texel's centre, in texels, both across and down. Without this limit, shapes narrower than a texel would become
// one or two texels wide.
const float OWN_NEAR = 0.3;

struct Splat {
    uint level;
    ivec2 low;    // texels whose centres it may cover
    ivec2 high;
    vec2 place;   // position of its centre, in texels
    ivec2 texel;  // texel that contains its centre
    vec3 offset;  // from the light, in the light's axes
    vec3 normal;
    float plane;  // normal · offset
    float least;  // least and most: bounds of its plane's distance in its own texel
    float most;
    float square; // square of the disc's radius widened by BESIDE texels
    float distance;
    Bounds bounds;  // relative to the light
};

// How far a point must lie in front of the light's plane: SLANT times its distance from the light, plus ROUNDING times the light's
// coordinates. The surface that the light sits on thus never counts as in front of the plane, however it is rounded.
const float SLANT = 1e-3;
const float ROUNDING = 1e-6;

// Returns whether a point lies in front of the light's plane; the paraboloid does not map other points.
bool is_before(vec3 origin, vec3 forward, vec3 offset) {
    precise float before = forward.x * offset.x + forward.y * offset.y + forward.z * offset.z;
    precise float far = SLANT * (abs(offset.x) + abs(offset.y) + abs(offset.z))
                      + ROUNDING * (abs(origin.x) + abs(origin.y) + abs(origin.z));
    return before > far;
}

// Returns whether a point in front of the light's plane casts a shadow. If near sides are culled, closed meshes cast with their far sides,
// as far from the light as possible. Source: Tokuyoshi 2014, Culling via DirectCompute.
bool is_seen(vec3 normal, vec3 forward, vec3 offset, bool closed) {
    vec3 along = ISM_SLIDE ? forward : offset;
    precise float away = normal.x * along.x + normal.y * along.y + normal.z * along.z;
    return !closed || ISM_CULLING == CULL_NONE || (ISM_CULLING == CULL_NEAR ? away > 0.0 : away < 0.0);
}

// Projects a point into the map; returns false if it leaves nothing there.
bool project(Axes axes, vec3 origin, IsmPoint point, float radius, Bounds bounds, out Splat splat) {
    precise vec3 offset = point.position - origin;
    vec3 normal = unpack_normal(point.normal);
    if (!is_before(origin, axes.forward, offset)
        || !is_seen(normal, axes.forward, offset, point_closed(point.normal))) {
        return false;
    }
    splat.offset = into_axes(axes, offset);
    splat.normal = into_axes(axes, normal);
    precise float square = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z;
    splat.distance = sqrt(square);
    precise float ahead = splat.distance + splat.offset.z;
    if (!(square < FARTHEST)) {
        return false;
    }
    precise vec2 place = splat.offset.xy / ahead * 0.5 + 0.5;
    precise float reach = radius / ahead * (0.5 * float(ISM_SIZE));
    splat.level = 0u;
    while (splat.level + 1u < ISM_LEVELS && reach > WIDEST) {
        reach *= 0.5;
        ++splat.level;
    }
    float side = float(level_side(splat.level));
    precise vec2 middle = place * side;
    if (!(all(lessThan(abs(middle), vec2(1e6))))) {
        return false;
    }
    splat.place = middle;
    splat.texel = ivec2(floor(middle));
    precise float plane = splat.normal.x * splat.offset.x + splat.normal.y * splat.offset.y + splat.normal.z * splat.offset.z;
    splat.plane = plane;
    // A slanted disc is narrower on the map, depending on the angle between the disc's normal and the map's axes at that position. But on
    // its near side the disc extends farther than an ellipse would.
    precise float wide = reach + BESIDE, slant = splat.normal.z + plane / splat.distance;
    precise vec2 across = splat.normal.xy - (2.0 * place - 1.0) * slant;
    precise vec2 narrow = sqrt(max(1.0 - across * across, 0.0)) * (1.0 + 2.0 * wide / side);
    precise vec2 extent = wide * min(narrow, vec2(1.0));
    int last = int(side) - 1;
    // Clamped at the map's border.
    splat.low = clamp(ivec2(ceil(middle - extent - 0.5)), ivec2(0), ivec2(last + 1));
    splat.high = clamp(ivec2(floor(middle + extent - 0.5)), ivec2(-1), ivec2(last));
    precise float near = splat.distance - radius, deep = ahead * (2.0 * DEEP / side);
    precise float most = splat.distance + max(radius, deep);
    splat.least = max(near, 0.5 * splat.distance);
    splat.most = most;
    precise float all = radius + ahead * (2.0 * BESIDE / side);
    splat.square = all * all;
    precise vec3 bounds_middle = bounds.middle - origin;
    splat.bounds = Bounds(bounds_middle, bounds.sides);
    return true;
}

// Returns whether the texel that contains the point stores it even if the disc misses the texel's centre. The texel must be inside the map;
// only rounding can put it outside, since the point is in front of the light's plane. With adaptive points, which are many, the point must
// also be close to the texel's centre.
bool takes_own(Splat splat) {
    vec2 off = abs(splat.place - vec2(splat.texel) - 0.5);
    bool near = !ISM_ADAPTIVE || all(lessThanEqual(off, vec2(OWN_NEAR)));
    return near && all(greaterThanEqual(splat.texel, ivec2(0))) && all(lessThan(splat.texel, ivec2(level_side(splat.level))));
}

// Returns the distance of the point's plane at the centre of its own texel, kept within about the disc's radius of the point's distance, so
// that flat surfaces stay flat.
uint own_distance(Splat splat) {
    vec3 way = map_way(texel_place(splat.level, splat.texel));
    precise float slope = splat.normal.x * way.x + splat.normal.y * way.y + splat.normal.z * way.z;
    precise float along = splat.plane / slope;
    precise float distance = along * (2.0 - way.z);
    return floatBitsToUint(along > 0.0 ? min(max(distance, splat.least), splat.most) : splat.distance);
}

// Returns whether a position, in the light's axes, is within the bounds of a disc.
bool in_bounds(Axes axes, Bounds bounds, vec3 place) {
    precise vec3 world = axes.right * place.x + axes.up * place.y + axes.forward * place.z;
    precise vec3 off = abs(world - bounds.middle);
    return all(lessThanEqual(off, bounds.sides));
}

// Returns the distance of the disc at the centre of a texel; NOTHING if the disc does not cover the texel.
uint disc_at(Axes axes, Splat splat, ivec2 texel) {
    vec2 place = texel_place(splat.level, texel);
    vec3 way = map_way(place);
    precise float slope = splat.normal.x * way.x + splat.normal.y * way.y + splat.normal.z * way.z;
    precise float along = splat.plane / slope;
    precise vec3 met = along * way;
    precise vec3 off = met - splat.offset;
    precise float square = off.x * off.x + off.y * off.y + off.z * off.z;
    precise float distance = along * (2.0 - way.z);
    bool covered = along > 0.0 && square <= splat.square && (!ISM_ADAPTIVE || in_bounds(axes, splat.bounds, met));
    return covered ? floatBitsToUint(distance) : NOTHING;
}
#endif
