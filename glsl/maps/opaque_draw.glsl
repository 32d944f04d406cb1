// Draws triangles into opaque maps in integer arithmetic. Corners are snapped to the nearest 256th of a texel. A triangle covers a texel if
// the texel's centre is inside the triangle. A centre exactly on an edge is inside only one of the two triangles that share the edge. So
// every device covers the same texels at the same depths, and each texel keeps the least depth. Source: Pineda 1988; clipping: Sutherland
// and Hodgman 1974. Twin: reference::twin::opaque.
#ifndef MAPS_OPAQUE_DRAW_GLSL
#define MAPS_OPAQUE_DRAW_GLSL
#define EXACT
#include "maps/edge.glsl"
#include "maps/opaque_set.glsl"
#include "maps/opaque_store.glsl"
#define ALPHA_TRIANGLES triangles
#include "maps/alpha_level.glsl"

// Steps per texel: corners are snapped to the nearest step.
const int OPAQUE_STEPS = 256;
// Triangles are clipped at this many times the distance from the map's centre to its edge, so that products of edge vectors stay within 52
// bits.
const float OPAQUE_GUARD = 1.5;
// Largest number of corners of a triangle after clipping by five planes.
const uint OPAQUE_CORNERS = 8u;
// Smallest value of (2 · area)², in world units: the normal of a smaller triangle would consist of rounding error.
const float OPAQUE_NO_AREA = 1e-30;
// Texels per side of the square that a workgroup draws at a time.
const int OPAQUE_TILE = 32;

// A triangle as a map sees it: a polygon in front of the near plane.
struct Seen {
    ivec2 places[OPAQUE_CORNERS];  // steps
    float all_z[OPAQUE_CORNERS];
    uint count;   // number of corners; 0 if no texel sees it
    uint number;  // index of the triangle
    uint alpha;   // alpha_number of the triangle
    ivec2 first;  // first of the texels whose centres are within its bounds
    ivec2 size;   // number of such texels along each axis
};

// Clip-space x and y, which are NDC · w, and z.
vec3 in_view(View view, vec3 corner) {
    precise vec3 offset = corner - view.origin;
    precise vec2 across = vec2(dot3(offset, view.right) * view.scale_x, dot3(offset, view.up) * view.scale_y);
    return vec3(across, dot3(offset, view.forward));
}

float w_of(View view, vec3 corner) { return view.projection == VIEW_PARALLEL ? 1.0 : corner.z; }

// Amount by which a corner is inside one of the five clipping planes; negative if it is outside.
float inside(View view, vec3 corner, uint plane) {
    float guard = OPAQUE_GUARD * w_of(view, corner);
    precise float away = plane == 0u ? corner.z - view.near
                         : plane == 1u ? guard - corner.x
                         : plane == 2u ? guard + corner.x
                         : plane == 3u ? guard - corner.y
                                       : guard + corner.y;
    return away;
}

// Where the edge from `a` to `b` crosses the plane. `a` is inside the plane by `here`; `b` is outside, by the negative number `there`. The
// edge is always given from its inner end, so that both triangles that share it get the same point.
vec3 cut(vec3 a, float here, vec3 b, float there) {
    precise float along = here - there;
    precise vec3 place = a + (here * reciprocal(along)) * (b - a);
    return place;
}

// Clips a polygon against all planes.
uint cut_off(View view, inout vec3 corners[OPAQUE_CORNERS], uint count) {
    for (uint plane = 0u; plane < 5u && count > 0u; ++plane) {
        vec3 before[OPAQUE_CORNERS] = corners;
        uint kept = 0u;
        for (uint i = 0u; i < count; ++i) {
            vec3 a = before[i], b = before[i + 1u < count ? i + 1u : 0u];
            float here = inside(view, a, plane), there = inside(view, b, plane);
            if (here >= 0.0) {
                corners[min(kept++, OPAQUE_CORNERS - 1u)] = a;
            }
            if ((here >= 0.0) != (there >= 0.0)) {
                corners[min(kept++, OPAQUE_CORNERS - 1u)] = here >= 0.0 ? cut(a, here, b, there) : cut(b, there, a, here);
            }
        }
        count = min(kept, OPAQUE_CORNERS);
    }
    return count;
}

ivec2 place_of(View view, vec3 corner) {
    precise vec2 ndc = view.projection == VIEW_PARALLEL ? corner.xy : corner.xy * reciprocal(corner.z);
    precise vec2 steps = (ndc * 0.5 + 0.5) * (vec2(view.width, view.height) * float(OPAQUE_STEPS));
    precise vec2 rounded = steps + 0.5;
    return ivec2(floor(rounded));
}

// Whether all corners are on the outer side of one plane that bounds the view.
bool unseen(View view, vec3 corners[OPAQUE_CORNERS]) {
    vec3 x = vec3(corners[0].x, corners[1].x, corners[2].x), y = vec3(corners[0].y, corners[1].y, corners[2].y);
    vec3 z = vec3(corners[0].z, corners[1].z, corners[2].z), w = view.projection == VIEW_PARALLEL ? vec3(1.0) : z;
    return all(lessThan(z, vec3(view.near))) || all(greaterThan(z, vec3(view.far))) || all(greaterThan(x, w)) ||
           all(lessThan(x, -w)) || all(greaterThan(y, w)) || all(lessThan(y, -w));
}

Seen see(View view, uint i) {
    Seen seen;
    seen.count = 0u;
    seen.number = i;
    seen.alpha = alpha_number(i);
    Triangle triangle = triangles[i];
    vec3 corners[OPAQUE_CORNERS];
    bool cuts = false;
    for (uint c = 0u; c < 3u; ++c) {
        corners[c] = in_view(view, triangle.corners[c]);
        float guard = OPAQUE_GUARD * w_of(view, corners[c]);
        cuts = cuts || corners[c].z < view.near || max(abs(corners[c].x), abs(corners[c].y)) > guard;
    }
    if (unseen(view, corners)) {
        return seen;
    }
    uint count = cuts ? cut_off(view, corners, 3u) : 3u;
    ivec2 low = ivec2(0x7fffffff), high = -low;
    for (uint c = 0u; c < count; ++c) {
        seen.places[c] = place_of(view, corners[c]);
        seen.all_z[c] = corners[c].z;
        low = min(low, seen.places[c]);
        high = max(high, seen.places[c]);
    }
    // Texels' centres are half a texel from their corners.
    seen.first = max((low + (OPAQUE_STEPS / 2 - 1)) >> 8, ivec2(0));
    ivec2 last = min((high - OPAQUE_STEPS / 2) >> 8, ivec2(view.width, view.height) - 1);
    seen.size = last - seen.first + 1;
    precise vec3 first_side = triangle.corners[1] - triangle.corners[0], side = triangle.corners[2] - triangle.corners[0];
    vec3 normal = cross3(first_side, side);
    float square = dot3(normal, normal);
    // A degenerate triangle casts no shadow, even if rounding gives it an area.
    if (count >= 3u && all(greaterThan(seen.size, ivec2(0))) && square > OPAQUE_NO_AREA) {
        // Asked last, so that the alpha of triangles outside the view is not read.
        bool see_through = ALPHA_FIRST != 0u && seen.alpha != 0u && alpha_record(seen.alpha).cutoff == ALPHA_SEE_THROUGH;
        seen.count = see_through ? 0u : count;
    }
    return seen;
}

// Number of tiles across and down the triangle's bounds.
ivec2 tiles_of(Seen seen) { return (seen.size + (OPAQUE_TILE - 1)) / OPAQUE_TILE; }

// Number of shares into which a triangle's tiles are divided; a workgroup draws one share at a time.
uint shares_of(ivec2 tiles) { return min(uint(tiles.x) * uint(tiles.y), OPAQUE_MOST_SHARES); }

// Each half of the low word is exact as a float, so that their sum is rounded once: SwiftShader rounds a 32-bit word twice.
float wide_float(Wide value) {
    precise float low = float(int(value.low >> 16)) * 65536.0 + float(int(value.low & 0xffffu));
    precise float sum = float(value.high) * 4294967296.0 + low;
    return sum;
}

// Adds 256 · `texels` to an edge function's value; 256 is the number of steps per texel.
Wide wide_step(Wide value, int texels) {
    uint carry;
    uint low = uaddCarry(value.low, uint(texels) << 8, carry);
    return Wide(value.high + (texels >> 24) + int(carry), low);
}

// Largest increase of an edge function within the part, in the unit of wide_step.
int most_step(ivec2 edge, ivec2 last) { return max(-edge.y, 0) * last.x + max(edge.x, 0) * last.y; }

bool covers(Wide value, bool owned) { return value.high >= 0 && (owned || (uint(value.high) | value.low) != 0u); }

// Stores a triangle at a texel that it covers, unless it has a hole there. `at`: the edges' values; `moved`: see `ray_from`.
void draw_texel(View view, ivec2 texel, Seen seen, vec3 at, vec3 weights, float area_divisor, vec3 moved, bool has_holes, Alpha alpha,
                AlphaPlane plane) {
    bool perspective = view.projection != VIEW_PARALLEL;
    // All terms have the same sign, so no precision is lost, even for thin triangles and for those that nearly reach the light.
    precise float mean = dot3(at, weights) * area_divisor;
    float z = max(perspective ? reciprocal(mean) : mean, view.near);
    Ray ray = perspective ? Ray(view.origin, moved) : Ray(moved, view.forward);
    if (has_holes) {
        precise vec3 place = ray.origin + z * ray.direction;
        if (!alpha_stands(alpha, seen.number, alpha_weights(plane, place))) {
            return;
        }
    }
    store(view, ray, texel, z, seen.number);
}

// Draws a part of a triangle: at most OPAQUE_TILE × OPAQUE_TILE texels, from `first` on. In each square of `every` × `every` texels it
// draws only the texel at `offset`, so that threads share the part. If `every` is 1, the part has at most 64 texels.
void draw_part(View view, ivec2 map_corner, Seen seen, ivec2 first, ivec2 offset, int every) {
    ivec2 size = min(seen.first + seen.size - first, ivec2(OPAQUE_TILE));
    bool perspective = view.projection != VIEW_PARALLEL;
    // `right`, `up`: change of rays from one texel to the next. `ray_from`: the ray through the map's centre, as its direction in
    // perspective, else as its origin. A texel's offset from the centre is exact.
    // A camera's scale_y is negative.
    precise vec3 right = view.right * (2.0 * sign(view.scale_x) * reciprocal(float(view.width) * abs(view.scale_x)));
    precise vec3 up = view.up * (2.0 * sign(view.scale_y) * reciprocal(float(view.height) * abs(view.scale_y)));
    vec2 half_size = 0.5 * vec2(view.width, view.height);
    vec3 ray_from = perspective ? view.forward : view.origin;
    ivec2 middle = OPAQUE_STEPS * first + OPAQUE_STEPS / 2;
    bool has_holes = ALPHA_FIRST != 0u && seen.alpha != 0u;
    Alpha alpha;
    AlphaPlane plane;
    if (has_holes) {
        alpha = alpha_record(seen.alpha);
        vec3 corners[3] = triangles[seen.number].corners;
        plane = alpha_plane(corners);
        alpha = alpha_at_level(alpha, alpha_level(view, corners, alpha));
    }
    for (uint i = 1u; i + 1u < seen.count; ++i) {
        ivec2 a = seen.places[0] - middle, b = seen.places[i] - middle, c = seen.places[i + 1u] - middle;
        vec3 all_z = vec3(seen.all_z[0], seen.all_z[i], seen.all_z[i + 1u]);
        Wide area = wide_cross(b - a, c - a);
        if (area.high < 0) {
            ivec2 b_was = b;
            b = c;
            c = b_was;
            all_z = all_z.xzy;
            area = wide_cross(b - a, c - a);
        }
        // Edges, each named after the opposite corner. An edge's value at a texel's centre is twice the area of the triangle formed by the
        // edge and the centre; here it is the value at the first texel.
        ivec2 edge_a = c - b, edge_b = a - c, edge_c = b - a;
        Wide value_a = wide_cross(edge_a, -b), value_b = wide_cross(edge_b, -c), value_c = wide_cross(edge_c, -a);
        bool own_a = owns_edge(edge_a), own_b = owns_edge(edge_b), own_c = owns_edge(edge_c);
        // Nothing to draw if even an edge's greatest value in the part is outside.
        ivec2 last = size - 1;
        if ((uint(area.high) | area.low) == 0u || !covers(wide_step(value_a, most_step(edge_a, last)), own_a) ||
            !covers(wide_step(value_b, most_step(edge_b, last)), own_b) ||
            !covers(wide_step(value_c, most_step(edge_c, last)), own_c)) {
            continue;
        }
        // A corner's weight at a texel is the value of the opposite edge, divided by the area.
        vec3 weights = perspective ? vec3(reciprocal(all_z.x), reciprocal(all_z.y), reciprocal(all_z.z)) : all_z;
        float area_divisor = reciprocal(wide_float(area));
        // Alpha takes long. So a thread that draws a triangle alone finds the texels first: threads that cover equally many then go on
        // together, wherever in their triangles the texels are.
        bool finds_first = has_holes && every == 1;
        uvec2 covered = uvec2(0u);
        for (int y = offset.y; y < size.y; y += every) {
            precise float across_y = float(first.y + y) + 0.5 - half_size.y;
            precise vec3 row = up * across_y;
            Wide row_a = wide_step(value_a, edge_a.x * y), row_b = wide_step(value_b, edge_b.x * y),
                 row_c = wide_step(value_c, edge_c.x * y);
            for (int x = offset.x; x < size.x; x += every) {
                Wide at_a = wide_step(row_a, -edge_a.y * x), at_b = wide_step(row_b, -edge_b.y * x),
                     at_c = wide_step(row_c, -edge_c.y * x);
                if (!covers(at_a, own_a) || !covers(at_b, own_b) || !covers(at_c, own_c)) {
                    continue;
                }
                if (finds_first) {
                    int number = y * size.x + x;
                    covered |= number < 32 ? uvec2(1u << number, 0u) : uvec2(0u, 1u << (number - 32));
                    continue;
                }
                vec3 at = vec3(wide_float(at_a), wide_float(at_b), wide_float(at_c));
                precise float across_x = float(first.x + x) + 0.5 - half_size.x;
                precise vec3 moved = ray_from + (right * across_x + row);
                draw_texel(view, map_corner + first + ivec2(x, y), seen, at, weights, area_divisor, moved, has_holes, alpha, plane);
            }
        }
        while ((covered.x | covered.y) != 0u) {
            bool is_early = covered.x != 0u;
            int number = is_early ? findLSB(covered.x) : 32 + findLSB(covered.y);
            covered = is_early ? uvec2(covered.x & (covered.x - 1u), covered.y) : uvec2(0u, covered.y & (covered.y - 1u));
            ivec2 texel = ivec2(number % size.x, number / size.x);
            Wide at_a = wide_step(wide_step(value_a, edge_a.x * texel.y), -edge_a.y * texel.x);
            Wide at_b = wide_step(wide_step(value_b, edge_b.x * texel.y), -edge_b.y * texel.x);
            Wide at_c = wide_step(wide_step(value_c, edge_c.x * texel.y), -edge_c.y * texel.x);
            vec3 at = vec3(wide_float(at_a), wide_float(at_b), wide_float(at_c));
            precise vec2 across = vec2(first + texel) + 0.5 - half_size;
            precise vec3 row = up * across.y;
            precise vec3 moved = ray_from + (right * across.x + row);
            draw_texel(view, map_corner + first + texel, seen, at, weights, area_divisor, moved, true, alpha, plane);
        }
    }
}

// Draws a share of a triangle's tiles, with all 64 threads of a workgroup.
void draw_share(View view, ivec2 map_corner, Seen seen, uint share) {
    ivec2 tiles = tiles_of(seen), offset = ivec2(gl_LocalInvocationIndex & 7u, gl_LocalInvocationIndex >> 3);
    uint count = uint(tiles.x) * uint(tiles.y), shares = shares_of(tiles);
    for (uint tile = share; tile < count; tile += shares) {
        ivec2 at = ivec2(tile % uint(tiles.x), tile / uint(tiles.x));
        draw_part(view, map_corner, seen, seen.first + OPAQUE_TILE * at, offset, 8);
    }
}
#endif
